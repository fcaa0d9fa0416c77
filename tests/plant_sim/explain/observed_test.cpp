// SPDX-License-Identifier: Apache-2.0
// What is worth a word in a channel of a log.
#include "explain/model/observed.hpp"

#include <CppUTest/TestHarness.h>

#include <random>

namespace voltlap::explain {
namespace {

/// A drawn drive of pulls, as a logger of this interval between rows has it, whose sensor is quiet at rest.
plant::Comparison drive_at(double row_s, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> seconds(1.0, 4.0), pull(50.0, 300.0);
  plant::Comparison out;
  const auto rows = static_cast<Index>(400.0 / row_s);
  out.log.time_s = VectorXd::LinSpaced(rows, 0.0, row_s * static_cast<double>(rows - 1));
  out.facts.current_a = VectorXd::Zero(rows);
  double until = 0.0, amperes = 0.0;
  for (Index row = 0; row < rows; ++row) {
    while (out.log.time_s(row) >= until) until += seconds(random), amperes = amperes > 0.0 ? 0.0 : pull(random);
    out.facts.current_a(row) = amperes;
  }
  return out;
}

double practical_v(const plant::Comparison& comparison) {
  return practical_size("voltage", plant::World{}, comparison, comparison.log);
}

}  // namespace

TEST_GROUP(Observed){};

TEST(Observed, WhereThePullsLieBetweenTheRowsAVoltageIsWorthAWordLater) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    DOUBLES_EQUAL(1e-3, practical_v(drive_at(0.01, seed)), 1e-12);
    DOUBLES_EQUAL(1e-3, practical_v(drive_at(0.1, seed)), 1e-12);
    DOUBLES_EQUAL(3e-3, practical_v(drive_at(2.0, seed)), 1e-12);
  }
}

TEST(Observed, ATestAtOneCurrentMayBeLoggedSeldom) {
  plant::Comparison test = drive_at(60.0, 1);
  test.facts.current_a.setConstant(30.0);
  DOUBLES_EQUAL(1e-3, practical_v(test), 1e-12);
  test.facts.current_a.setZero();
  DOUBLES_EQUAL(1e-3, practical_v(test), 1e-12);
}

}  // namespace voltlap::explain
