// SPDX-License-Identifier: Apache-2.0
// What pays: a set that makes the plain error smaller, not only the weighed one.
#include "discrepancy/gain.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 4800;  // 10 Hz, eight blocks of a minute
constexpr double kNoise = 1e-3;

VectorXd noise(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, kNoise);
  VectorXd out(kRows);
  for (double& v : out) v = normal(random);
  return out;
}

}  // namespace

/// Cells' voltage and the pack's against them; candidate 0 acts on the first, candidate 1 on the second, candidate 2 is a
/// shape without a name that references know.
TEST_GROUP(Pays) {
  std::vector<Cause> causes{2};
  Design design;
  std::vector<Candidate> locals;
  System system;
  NoiseModel known{{"voltage", {}}, {"pack_voltage", {}}};
  Usual usual;
  std::vector<bool> use;
  std::vector<WeighedSet> sets;
  Decision decision;
  Parts parts;
  VectorXd wave;

  void setup() override {
    Comparison& on = design.comparison;
    on.log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    wave = (on.log.time_s.array() * 0.7).sin();
    const VectorXd usually = (on.log.time_s.array() * 0.05).cos();
    on.channels = {{"voltage", Balance::kVoltage, "V", VectorXd()}, {"pack_voltage", Balance::kVoltage, "V", VectorXd()}};
    for (int k = 0; k < 3; ++k) {
      Column column;
      column.cause = k < 2 ? k : -1;
      column.effect.resize(2);
      column.effect[k == 1 ? 1 : 0] = k < 2 ? wave : usually;
      design.columns.push_back(column);
      Candidate candidate;
      candidate.cause = column.cause;
      candidate.rows = {k};
      system.candidates.push_back(candidate);
    }
    usual.mean = VectorXd::Zero(3);
    system.prior_variance = VectorXd::Ones(3);
  }

  /// The voltage's residual is these amounts of its columns; the pack's a little of its own.
  Pays pays_of(double amount, double usually, std::size_t candidate, const std::vector<std::size_t>& beside = {}) {
    design.residual = {noise(1) + amount * wave + usually * design.columns[2].effect[0], noise(2) + 1e-5 * wave};
    parts.quarters.assign(4, system);
    for (System& quarter : parts.quarters) quarter.information = MatrixXd::Zero(3, 3), quarter.score = VectorXd::Zero(3);
    for (Index row = 0; row < kRows; ++row) {
      System& quarter = parts.quarters[static_cast<std::size_t>(row / 600 % 4)];
      for (int k = 0; k < 3; ++k) {
        const std::size_t c = k == 1 ? 1 : 0;
        const double x = design.columns[static_cast<std::size_t>(k)].effect[c](row);
        quarter.information(k, k) += x * x;
        quarter.score(k) += x * design.residual[c](row);
      }
    }
    system.information = MatrixXd::Zero(3, 3);
    system.score = VectorXd::Zero(3);
    for (const System& quarter : parts.quarters) system.information += quarter.information, system.score += quarter.score;
    usual.inflation = {1.0, 1.0};
    usual.variance = MatrixXd::Zero(3, 3);
    const Refinery refinery(design, causes, system, known, usual, std::vector<bool>(kRows, true));
    const Judged judged{causes, design, locals, system, known, usual, use, sets, decision, parts, refinery, nullptr};
    return pays(judged, {candidate}, beside);
  }

  bool plainly(double amount, double usually, std::size_t candidate, const std::vector<std::size_t>& beside = {}) {
    return pays_of(amount, usually, candidate, beside) == Pays::kPlainly;
  }
};

TEST(Pays, AnEffectAsLargeAsTheNoisePaysAndAFiftiethOfItDoesNot) {
  CHECK(plainly(kNoise, 0.0, 0));
  CHECK(pays_of(0.02 * kNoise, 0.0, 0) == Pays::kNot);
}

TEST(Pays, WhatReferencesKnowIsTakenAwayFirst) {
  const double much = 10.0 * kNoise;  // beside it the effect is one in a hundred of the squares
  CHECK_FALSE(plainly(kNoise, much, 0));
  usual.mean(2) = much;
  CHECK(plainly(kNoise, much, 0));
}

TEST(Pays, BetweenTwoSensorsNoErrorOfAModelStands) {
  CHECK(plainly(0.0, 0.0, 1));
}

TEST(Pays, AShapeWithoutANameHasToPayToo) {
  CHECK_FALSE(plainly(0.0, 0.02 * kNoise, 2));
  CHECK(plainly(0.0, kNoise, 2));
}

TEST(Pays, BesideAnotherCauseOnlyWhatThatOneLeavesCounts) {
  // Ten parts of one beside two of the other: alone the small one is lost, beside the large one it pays.
  CHECK_FALSE(plainly(10.0 * kNoise, 2.0 * kNoise, 2));
  CHECK(plainly(10.0 * kNoise, 2.0 * kNoise, 2, {0}));
  CHECK_FALSE(plainly(10.0 * kNoise, 0.02 * kNoise, 2, {0}));
}

TEST(Pays, AFastEffectInASlowErrorPaysOnceTheSlowIsFilteredOut) {
  const double slow = 10.0 * kNoise, fast = 0.2 * kNoise;  // one in 2500 of the squares
  known["voltage"] = {kNoise, slow, 30.0, 0.0};
  CHECK(pays_of(fast, slow, 0) == Pays::kInNoise);
  CHECK(pays_of(0.02 * kNoise, slow, 0) == Pays::kNot);
}
