// SPDX-License-Identifier: Apache-2.0
// The pack voltage against the sum of the cells, beyond the 5 % of BMS-022. At rest the ratio of the two says how many
// cells there are and what the gain of the pack's channel is; while the current is steady the two agree within one
// cell's worth after that. A channel that stands still while the cells move is frozen.
#pragma once
#include <cstdint>

#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/slow_mean.hpp"

namespace voltlap::bms {

struct State;

/// Written by voltage_check.
struct VoltageCheck {
  Ratio gain{};                ///< pack voltage per sum of cells, at rest
  bool gain_known = false;
  bool count_wrong = false;    ///< at rest: as if there were another number of cells
  std::int64_t apart = 0;      ///< [0.1 mV] mean of pack less sum over 200 ms
  std::int64_t pack_late = 0, sum_late = 0;  ///< [0.1 mV] both, 250 ms late
  LastShare share{}, late_share{};
  bool lasting = false;        ///< that mean, and what no lag makes of it, are half of what BMS-022 allows, or more
  Current steady_at{};         ///< the current that it has been steady about
  Instant steady_since{};
  bool steady = false;
  bool cell_missing = false;   ///< at steady current: more than one cell's worth apart
  bool watched = false;
  PackVoltage still_at{};      ///< what the pack's channel has said ...
  Instant still_since{};       ///< ... since then
  PackVoltage still_sum{};     ///< sum of the cells at the begin of that, when lags are over
  bool frozen = false;         ///< the cells have moved since, the pack's channel has not
};

void check_pack_voltage(const Config& config, Instant now, Duration elapsed, State& state);

}  // namespace voltlap::bms
