// SPDX-License-Identifier: Apache-2.0
#include "estimate.hpp"

#include <random>
#include <stdexcept>

#include <CppUTest/TestHarness.h>

using namespace voltlap::benchmarks;

namespace {

constexpr double kReference_ns = 250e3;

/// Two stretches of 1 ms and 3 ms, at most `noise` times longer, on a machine that is `slow` times slower.
Repetitions disturbed(int count, double noise, double slow = 1.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> longer(1.0, 1.0 + noise);
  Repetitions out;
  for (int i = 0; i < count; ++i) {
    std::vector<Stretch> stretches;
    for (const double work_ns : {1e6, 3e6}) {
      stretches.push_back({work_ns * slow * longer(random), kReference_ns * slow * longer(random)});
    }
    out.push_back(stretches);
  }
  return out;
}

Estimate of(const Repetitions& repetitions) { return estimate(repetitions, 1000.0, reference_time_ns({repetitions})); }

}  // namespace

TEST_GROUP(Estimate){};

TEST(Estimate, UndisturbedTimesGiveTheTimeOfOneOperation) {
  const Estimate e = of(disturbed(10, 0.0));
  DOUBLES_EQUAL(4000.0, e.ns, 1e-9);
  DOUBLES_EQUAL(4000.0 / kReference_ns, e.relative, 1e-15);
  DOUBLES_EQUAL(e.relative, e.low, 1e-15);
  DOUBLES_EQUAL(e.relative, e.high, 1e-15);
  DOUBLES_EQUAL(0.0, e.spread, 1e-15);
}

TEST(Estimate, QuickestOfEachStretchCountsNotTheQuickestRepetition) {
  const Repetitions repetitions = {{{1e6, 1e5}, {9e6, 1e5}}, {{5e6, 1e5}, {3e6, 1e5}}};
  DOUBLES_EQUAL(4e6, estimate(repetitions, 1.0, 1e5).ns, 1e-6);
}

TEST(Estimate, DisturbancesThatOnlyLengthenHardlyMoveIt) {
  const double quiet = of(disturbed(20, 0.0)).relative;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const double noisy = of(disturbed(20, 0.8, 1.0, seed)).relative;
    CHECK(noisy / quiet > 0.85 && noisy / quiet < 1.15);
  }
}

TEST(Estimate, MachineThatIsSlowerTodayDoesNotCount) {
  const Estimate fast = of(disturbed(20, 0.1)), slow = of(disturbed(20, 0.1, 1.7));
  DOUBLES_EQUAL(1.7, slow.ns / fast.ns, 1e-9);
  DOUBLES_EQUAL(fast.relative, slow.relative, 1e-12);
}

TEST(Estimate, IntervalHoldsTheEstimateAndGrowsWithTheNoise) {
  const Estimate calm = of(disturbed(20, 0.02)), wild = of(disturbed(20, 0.8));
  for (const Estimate& e : {calm, wild}) CHECK(e.low <= e.relative * 1.03 && e.high >= e.relative && e.high >= e.low);
  CHECK(wild.high - wild.low > 5.0 * (calm.high - calm.low));
  CHECK(wild.spread > 5.0 * calm.spread);
}

TEST(Estimate, RowWhoseStretchesAllMetABusyMachineIsNoEvidence) {
  Repetitions quiet = disturbed(20, 0.02), busy = disturbed(2, 0.02, 1.5);
  const double reference_ns = reference_time_ns({quiet, busy});
  const Estimate e = estimate(busy, 1000.0, reference_ns), undisturbed = estimate(quiet, 1000.0, reference_ns);
  CHECK(e.relative > 1.4 * undisturbed.relative);
  CHECK(e.low < 1.03 * undisturbed.relative);
}

TEST(Estimate, NothingMeasuredAndUnequalWorkAreRefused) {
  CHECK_THROWS(std::invalid_argument, (void)estimate({}, 1.0, 1.0));
  CHECK_THROWS(std::invalid_argument, (void)estimate({{}}, 1.0, 1.0));
  CHECK_THROWS(std::invalid_argument, (void)estimate({{{1, 1}}, {{1, 1}, {1, 1}}}, 1.0, 1.0));
  CHECK_THROWS(std::invalid_argument, (void)reference_time_ns({}));
}
