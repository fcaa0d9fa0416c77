// SPDX-License-Identifier: Apache-2.0
// A whole endurance under one kind of limit, by a BMS that believes a wrong resistance: does it trip, does its limit
// hunt, and what does it cost.
#pragma once
#include <functional>
#include <string>

#include "bms/config.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

struct LimitRaceResult {
  EnduranceResult drive;
  int reversals = 0;          ///< of the limit: down and up again by kReversal_a within kReversal_s while it binds
  double bound_s = 0.0;       ///< that it bound
  double lowest_cell_v = 0.0;
  bool under_voltage = false; ///< a trip of a cell's low voltage
};

inline constexpr double kReversal_a = 20.0, kReversal_s = 1.0;

/// `resistance`: what the BMS is told of the truth, as a factor.
[[nodiscard]] LimitRaceResult run_limit_race(const EnduranceOptions& options, bms::LimitMethod method,
                                             double resistance, const std::function<bool(double)>& progress);

}  // namespace voltlap::plant
