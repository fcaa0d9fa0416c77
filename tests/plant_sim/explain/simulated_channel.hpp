// SPDX-License-Identifier: Apache-2.0
// A channel of known columns and noise, for tests of what is fitted to it.
#pragma once
#include <cmath>
#include <limits>
#include <random>

#include "explain/fit/hypothesis.hpp"

namespace voltlap::explain {

inline constexpr Index kBins = 2400, kBlocks = 8;
inline constexpr double kStep_s = 0.2, kSlow_s = 50.0;  // s; bins, and how long slow noise stays

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
  [[nodiscard]] VectorXd late_wave() const { return channel_.values.col(2); }
  /// In the place of the wave.
  void be_wave(const VectorXd& values) { channel_.values.col(1) = values; }
  [[nodiscard]] Problem problem() const {
    Problem out;
    out.channels.emplace_back(channel_, noise_grid(false), kBlocks);
    out.prior_sigma = VectorXd::Constant(3, 100.0);
    out.least_sigma = {1e-6};
    out.most_slow = {std::numeric_limits<double>::infinity()};
    out.nuisances = {0};
    out.free = 1;
    out.blocks = kBlocks;
    return out;
  }

 private:
  ChannelColumns channel_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

}  // namespace voltlap::explain
