// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/holdout_blocks.hpp"

#include <cmath>

#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(HoldoutBlocks) {
  MeasuredRun run = make_run(KnownCell{}.record([] {
    std::vector<double> plan;
    for (int pulse = 0; pulse < 6; ++pulse) {
      plan.insert(plan.end(), 100, 0.0);
      plan.insert(plan.end(), 50, 30.0);
    }
    return plan;
  }()),
                         {});
};

TEST(HoldoutBlocks, WindowBeginsWithEachPulseAndLastsItsTime) {
  const auto windows = pulse_windows(run, 20.0);
  LONGS_EQUAL(6, windows.size());
  LONGS_EQUAL(100, windows[0].first);
  LONGS_EQUAL(20, windows[0].last - windows[0].first);
}

TEST(HoldoutBlocks, WindowWithAFreeStateIsLeftOut) {
  run.reset[105] = true;
  const auto windows = pulse_windows(run, 20.0);
  LONGS_EQUAL(5, windows.size());
  LONGS_EQUAL(250, windows[0].first);
}

TEST(HoldoutBlocks, EverySecondBlockLosesItsWeightAndItsScoreIsItsOwn) {
  const auto blocks = time_blocks(run, 60.0);
  LONGS_EQUAL(15, blocks.size());
  const MeasuredRun kept = without_every_second(run, blocks, 1);
  DOUBLES_EQUAL(0.0, kept.weight_s(70), 0.0);
  DOUBLES_EQUAL(1.0, kept.weight_s(30), 0.0);
  Eigen::VectorXd error = Eigen::VectorXd::Constant(run.rows(), 1.0);
  error.segment(60, 60).setConstant(2.0);
  DOUBLES_EQUAL((2.0 + 6.0) / 7.0, score_every_second(run, error, blocks, 1).mean(), 1e-9);
  DOUBLES_EQUAL(1.0, score_every_second(run, error, blocks, 0).mean(), 1e-9);
  // The same blocks twice as bad: the difference is their own rms, its error from how those scatter.
  const BlockScore one = score_every_second(run, error, blocks, 1),
                   two = score_every_second(run, 2.0 * error, blocks, 1);
  DOUBLES_EQUAL(0.0, standard_error_of_difference(one, one), 1e-12);
  const double mean = 8.0 / 7.0, squares = (2.0 - mean) * (2.0 - mean) + 6.0 * (1.0 - mean) * (1.0 - mean);
  DOUBLES_EQUAL(std::sqrt(squares / 6.0 / 7.0), standard_error_of_difference(two, one), 1e-9);
}

TEST(HoldoutBlocks, ErrorSinceOnsetForgetsWhatWasThereBefore) {
  const auto windows = pulse_windows(run, 20.0);
  const Eigen::VectorXd error = Eigen::VectorXd::LinSpaced(run.rows(), 5.0, 5.0);
  DOUBLES_EQUAL(0.0, since_onset(error, windows)(110), 1e-15);
  DOUBLES_EQUAL(5.0, since_onset(error, windows)(10), 1e-15);
}
