// SPDX-License-Identifier: Apache-2.0
// Stints of a drive and the length of its lap, from the speed alone: a course asks for the same speed in every lap.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "explain/balances/recording.hpp"

namespace voltlap::plant {

/// Driving without a stop.
struct Stint {
  Eigen::Index first = 0;
  Eigen::VectorXd position_m;  ///< from the beginning of the stint, by row
};

/// The longest stints, at most `most`, in the order of driving.
[[nodiscard]] std::vector<Stint> stints_of(const Recording& log, std::size_t most);

/// Metres after which the speed over the way repeats; 0 if it does not.
[[nodiscard]] double lap_length(const Recording& log, const std::vector<Stint>& stints);

}  // namespace voltlap::plant
