// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/hypothesis.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>

namespace voltlap::explain {
namespace {

constexpr Index kBins = 2400, kBlocks = 8;
constexpr double kStep_s = 0.2, kSlow_s = 50.0;  // s; bins, and how long slow noise stays

/// A channel of a wave, a constant (as a start is) and noise, white and slow.
class SimulatedChannel {
 public:
  explicit SimulatedChannel(unsigned seed) : random_(seed) {
    channel_.time_s = VectorXd::LinSpaced(kBins, 0.0, kStep_s * (kBins - 1));
    channel_.rough = VectorXd::Zero(kBins);
    channel_.values.resize(kBins, 4);
    channel_.values.col(0).setOnes();
    channel_.values.col(1) = (channel_.time_s.array() * 0.7).sin();
    channel_.values.col(2) = (channel_.time_s.array() * 0.7).cos();
    channel_.values.col(3).setZero();
    channel_.column = {0, 1, 2};
    for (Index k = 0; k < kBins; ++k) channel_.block.push_back(k * kBlocks / kBins);
  }
  void add(const VectorXd& values) { channel_.values.col(3) += values; }
  void add_white(double sigma) {
    for (Index k = 0; k < kBins; ++k) channel_.values(k, 3) += sigma * normal_(random_);
  }
  void add_slow(double sigma) {
    const double keeps = std::exp(-kStep_s / kSlow_s);
    double slow = sigma * normal_(random_);
    for (Index k = 0; k < kBins; ++k) {
      channel_.values(k, 3) += slow;
      slow = keeps * slow + std::sqrt(1.0 - keeps * keeps) * sigma * normal_(random_);
    }
  }
  [[nodiscard]] VectorXd wave() const { return channel_.values.col(1); }
  [[nodiscard]] Problem problem() const {
    Problem out;
    out.channels.push_back(gram_of(channel_, noise_grid(false), kBlocks));
    out.prior_sigma = VectorXd::Constant(3, 100.0);
    out.least_sigma = {1e-6};
    out.nuisances = {0};
    out.blocks = kBlocks;
    return out;
  }

 private:
  ChannelColumns channel_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

}  // namespace

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

}  // namespace voltlap::explain
