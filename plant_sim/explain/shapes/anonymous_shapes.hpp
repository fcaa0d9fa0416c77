// SPDX-License-Identifier: Apache-2.0
// Shapes that a residual could have and that no cause owns: plain functions of current, charge, time, heat, speed
// and torque, and the same behind lags. When they take what the catalogue leaves, the cause is unknown.
#pragma once
#include <string>
#include <vector>

#include "explain/balances/balances.hpp"

namespace voltlap::plant {

/// A log beside what the model makes of it.
struct Shown {
  const World& model;
  const Comparison& comparison;
  const Prediction& base;
};

/// A shape of one channel, by row of the log, in the channel's usual size.
struct Shape {
  std::string key;
  std::size_t channel;
  double usual;  ///< how much of it a sound model misses, one sigma
  Eigen::VectorXd effect;
};

[[nodiscard]] std::vector<Shape> anonymous_shapes(const Shown& shown);

/// Size [V, K, Nm, m/s, rpm] that counts as usual for a shape in this channel.
[[nodiscard]] double usual_size(const BalanceChannel& channel, double cells_in_series);

}  // namespace voltlap::plant
