// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/hypothesis.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>

#include "simulated_channel.hpp"

namespace voltlap::explain {

TEST_GROUP(Hypothesis){};

TEST(Hypothesis, AnEffectIsFoundWithItsSizeAndNoiseBringsNone) {
  int inside = 0, by_chance = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SimulatedChannel channel(seed);
    channel.add_white(1.0);
    channel.add(0.3 * channel.wave());
    const Problem problem = channel.problem();
    const Fit nothing = fit_of(problem, {}), right = fit_of(problem, {1}), wrong = fit_of(problem, {2});
    CHECK_TEXT(lead_of(right, nothing).decisive, "an effect of ten standard errors");
    if (lead_of(wrong, nothing).decisive || lead_of(fit_of(problem, {1, 2}), right).decisive) ++by_chance;
    const double sigma = std::sqrt(right.covariance(1, 1));
    DOUBLES_EQUAL(std::sqrt(2.0 / kBins), sigma, 0.1 * sigma);
    if (std::abs(right.size(1) - 0.3) < 1.96 * sigma) ++inside;
  }
  CHECK_TEXT(by_chance <= 3, "of 80 columns that are not there, decisive at ln 20: three would be chance");
  CHECK_TEXT(inside >= 34, "of 40 intervals of 95 % at least 34 hold the true size");  // fewer: 1 in 300
}

TEST(Hypothesis, ABlockOrAChannelWithoutReadingsSaysNothing) {
  ChannelColumns none{VectorXd(0), VectorXd(0), RowsXd(0, 3), {0, 1}, {}};
  SimulatedChannel channel(5);
  channel.add_white(1.0);
  channel.add(channel.wave());
  Problem problem = channel.problem(), beside = problem;
  beside.channels.emplace_back(none, noise_grid(false), kBlocks);
  beside.least_sigma.push_back(1e-6);
  beside.most_slow.push_back(1.0);
  const Fit alone = fit_of(problem, {1}), both = fit_of(beside, {1});
  DOUBLES_EQUAL(alone.size(1), both.size(1), 1e-12);
  DOUBLES_EQUAL(alone.total(), both.total(), 1e-9);
}

TEST(Hypothesis, SlowNoiseIsNoEffect) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SimulatedChannel channel(seed);
    channel.add_white(0.2);
    channel.add_slow(1.0);
    const Problem problem = channel.problem();
    const Fit nothing = fit_of(problem, {});
    CHECK(noise_grid(false)[nothing.noise[0]].slow_share > 0.0);
    CHECK_FALSE(lead_of(fit_of(problem, {1}), nothing).decisive);
  }
}

TEST(Hypothesis, WhatIsSlowerAndLargerThanInSoundLogsIsNoNoise) {
  SimulatedChannel channel(3);
  channel.add_white(0.2);
  channel.add_slow(1.0);
  Problem problem = channel.problem();
  CHECK(slow_noise(problem, fit_of(problem, {}), 0) > 0.3);
  problem.most_slow = {0.1};
  const Fit bounded = fit_of(problem, {});
  CHECK(slow_noise(problem, bounded, 0) <= 0.1 * (1.0 + 1e-9));
}

TEST(Hypothesis, AStartTakesNoMoreThanItCan) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SimulatedChannel channel(seed);
    channel.add_white(0.5);
    channel.add(VectorXd::Constant(kBins, 10.0));
    Problem problem = channel.problem();
    problem.prior_sigma(0) = 1.0;  // so that 3 is the most
    const Fit kept = fit_of(problem, {1});
    DOUBLES_EQUAL(3.0, kept.size(0), 1e-9);
    DOUBLES_EQUAL(3.0, kept.plain_starts(0), 1e-9);
    DOUBLES_EQUAL(7.0 * 7.0 + 0.25, kept.left.sum() / kBins, 1.0);
    problem.prior_sigma(0) = 100.0;
    const Fit free = fit_of(problem, {1});
    DOUBLES_EQUAL(10.0, free.size(0), 0.1);
    CHECK_TEXT(free.total() > kept.total() + 50.0, "every minute speaks against a start that cannot be");
  }
}

TEST(Hypothesis, OneBlockAloneDecidesNothing) {
  SimulatedChannel channel(7);
  channel.add_white(1.0);
  VectorXd in_one_block = 3.0 * channel.wave();
  in_one_block.tail(kBins - kBins / kBlocks).setZero();
  channel.add(in_one_block);
  const Problem problem = channel.problem();
  CHECK_FALSE(lead_of(fit_of(problem, {1}), fit_of(problem, {})).decisive);
}

TEST(Hypothesis, WhatIsLeftIsMeasuredFromAPlainStartWhereSlowNoiseLeavesItOpen) {
  SimulatedChannel channel(3);
  channel.add_white(0.1);
  channel.add_slow(1.0);
  channel.add(VectorXd::Constant(kBins, 5.0));
  const Problem problem = channel.problem();
  const Fit fit = fit_of(problem, {});
  const MatrixXd& gram = problem.channels[0].all[0].gram;
  const double mean = gram(3, 0) / gram(0, 0);
  CHECK_TEXT(std::abs(fit.size(0) - mean) > 1e-3, "the ends of a slow noise weigh more: else this proves nothing");
  DOUBLES_EQUAL(mean, fit.plain_starts(0), 1e-6);
  DOUBLES_EQUAL(gram(3, 3) - mean * gram(3, 0), fit.left.sum(), 1e-3 * fit.left.sum());
}

TEST(Hypothesis, ACurveGoesOnStraightWhereNothingTellsHowItBends) {
  // Three points of a curve, the last of which acts on no reading: it continues the line of the first two.
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ChannelColumns channel;
    channel.time_s = VectorXd::LinSpaced(600, 0.0, 599.0);
    channel.rough = VectorXd::Zero(600);
    channel.values = RowsXd::Zero(600, 4);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double first = 3.0 * normal(random), second = 3.0 * normal(random);
    for (Index k = 0; k < 600; ++k) {
      channel.values(k, k < 300 ? 0 : 1) = 1.0;
      channel.values(k, 3) = (k < 300 ? first : second) + 0.01 * normal(random);
      channel.block.push_back(k / 100);
    }
    channel.column = {0, 1, 2};
    Problem problem;
    problem.channels.emplace_back(channel, noise_grid(false), 6);
    problem.prior_sigma = VectorXd::Constant(3, 1000.0);
    problem.least_sigma = {1e-6};
    problem.most_slow = {std::numeric_limits<double>::infinity()};
    problem.blocks = 6;
    DOUBLES_EQUAL(0.0, fit_of(problem, {0, 1, 2}).size(2), 1e-9);
    problem.curves = {{0, 3, 1.0}};
    DOUBLES_EQUAL(2.0 * second - first, fit_of(problem, {0, 1, 2}).size(2), 0.05);
  }
}

}  // namespace voltlap::explain
