// SPDX-License-Identifier: Apache-2.0
#include "car/battery/branch_reduction.hpp"

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "car/battery/cell.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// A cell that is the same everywhere, with a flat OCV; `branches` as ohm and s.
CellParameters cell_of(const std::vector<std::pair<double, double>>& branches) {
  CellParameters out = constant_cell();
  out.branches = {};
  for (std::size_t k = 0; k < branches.size(); ++k) {
    out.branches[k] = {{{branches[k].first}, 0.0, 0.0, {}}, {{branches[k].second}, 0.0, 0.0, {}}};
  }
  return out;
}

CellParameters cell_of(const CircuitOf<2>& circuit) {
  CellParameters out = cell_of({{circuit.r_ohm[0], circuit.tau_s[0]}, {circuit.r_ohm[1], circuit.tau_s[1]}});
  out.r0_ohm.value = {circuit.r0_ohm};
  return out;
}

/// OCV less voltage of a cell [V], `at_s` after the begin of a current.
double drop_after(const CellParameters& parameters, double current_a, double at_s) {
  const Cell cell(parameters);
  CellState state;
  state.soc = 0.5;
  cell.look_up(state, {current_a, state.soc, 30.0});
  cell.advance(state, {at_s, current_a, current_a}, {current_a, state.soc, 30.0});
  return cell.drop_v(state, current_a);
}

CircuitParameters circuit_of(const CellParameters& cell) { return CellTables(cell).circuit(0.5, 30.0, 100.0); }

std::uint64_t seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
}

}  // namespace

TEST_GROUP(BranchReduction){};

TEST(BranchReduction, OneOrTwoBranchesComeBackAsTheyAre) {
  const CircuitOf<2> two = two_branches(circuit_of(cell_of({{4e-4, 33.0}, {8e-4, 161.0}})), 2);
  DOUBLES_EQUAL(0.0012, two.r0_ohm, 0.0);
  DOUBLES_EQUAL(4e-4, two.r_ohm[0], 0.0);
  DOUBLES_EQUAL(8e-4, two.r_ohm[1], 0.0);
  DOUBLES_EQUAL(161.0, two.tau_s[1], 0.0);
  const CircuitOf<2> one = two_branches(circuit_of(cell_of({{4e-4, 33.0}})), 1);
  DOUBLES_EQUAL(4e-4, one.r_ohm[0], 0.0);
  DOUBLES_EQUAL(0.0, one.r_ohm[1], 0.0);
  const BranchReduction none = reduce_branches(cell_of({{4e-4, 33.0}}), {0.2, 0.8});
  DOUBLES_EQUAL(0.0, none.largest_v, 1e-15);
}

TEST(BranchReduction, ThreeBranchesThatActAsTwoAreReducedExactly) {
  // Two of one time constant; one that is over long before the first second.
  const CircuitParameters twins = circuit_of(cell_of({{4e-4, 12.0}, {3e-4, 200.0}, {5e-4, 200.0}}));
  const CircuitOf<2> found = two_branches(twins, 3);
  DOUBLES_EQUAL(4e-4, found.r_ohm[0], 1e-8);
  DOUBLES_EQUAL(8e-4, found.r_ohm[1], 1e-8);
  DOUBLES_EQUAL(12.0, found.tau_s[0], 1e-3);
  DOUBLES_EQUAL(200.0, found.tau_s[1], 1e-2);
  CHECK(step_error(twins, found).largest_ohm < 1e-9);
  const CircuitParameters quick = circuit_of(cell_of({{2e-4, 1e-2}, {4e-4, 12.0}, {8e-4, 200.0}}));
  const CircuitOf<2> rest = two_branches(quick, 3);
  DOUBLES_EQUAL(0.0012 + 2e-4, rest.r0_ohm, 1e-7);
  CHECK(step_error(quick, rest).largest_ohm < 1e-8);
}

TEST(BranchReduction, TheStatedErrorIsThatOfBothSimulated) {
  const std::uint64_t drawn = seed();
  std::mt19937_64 random{drawn};
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<std::pair<double, double>> branches;
    double tau = between(0.5, 5.0);
    for (int k = 0; k < (trial % 2 == 0 ? 3 : 4); ++k, tau *= between(4.0, 12.0))
      branches.emplace_back(between(2e-4, 2e-3), tau);
    const CellParameters whole = cell_of(branches);
    const BranchReduction stated = reduce_branches(whole, {0.5});
    const CellParameters reduced = cell_of(stated.circuits[0]);
    double largest = 0.0, square = 0.0;
    constexpr int kTimes = 60;
    for (int k = 0; k < kTimes; ++k) {
      const double at_s = std::pow(600.0, k / (kTimes - 1.0));
      const double off = drop_after(reduced, whole.capacity_ah, at_s) - drop_after(whole, whole.capacity_ah, at_s);
      largest = std::max(largest, std::abs(off));
      square += off * off / kTimes;
    }
    const std::string text = "VOLTLAP_TEST_SEED=" + std::to_string(drawn) + ", trial " + std::to_string(trial);
    DOUBLES_EQUAL_TEXT(largest, stated.largest_v, 1e-9, text.c_str());
    DOUBLES_EQUAL_TEXT(std::sqrt(square), stated.rms_v, 1e-9, text.c_str());
    CHECK_TEXT(stated.rms_v > 0.0, text.c_str());
  }
}

TEST(BranchReduction, NoCircuitNearbyFollowsTheStepBetter) {
  const CircuitParameters whole = circuit_of(cell_of({{5e-4, 2.0}, {7e-4, 25.0}, {9e-4, 400.0}}));
  const CircuitOf<2> found = two_branches(whole, 3);
  const double least = step_error(whole, found).rms_ohm;
  CHECK(least > 1e-6);
  for (const double factor : {0.999, 1.001}) {
    for (int what = 0; what < 5; ++what) {
      CircuitOf<2> other = found;
      double* const parts[] = {&other.r0_ohm, &other.r_ohm[0], &other.r_ohm[1], &other.tau_s[0], &other.tau_s[1]};
      *parts[what] *= factor;
      CHECK(step_error(whole, other).rms_ohm > least);
    }
  }
}
