// SPDX-License-Identifier: Apache-2.0
// How much current the pack may give and take, and what sets it. One interface, the methods are sibling files
// (equation, table, ahead) chosen by Config::limit_method; what holds for all of them is here: no limit without
// measurements, the maximum of the configuration, temperature, low charge, and how fast a limit rises.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// What the measurements allow now, before the rise is slowed.
[[nodiscard]] Limit discharge_ceiling(const Config& config, const State& state);
[[nodiscard]] Limit charge_ceiling(const Config& config, const State& state);

/// A limit falls at once and rises by at most config.limit_rise_per_s; while it rises it keeps its last reason.
[[nodiscard]] Limit follow(const Config& config, Limit previous, Limit ceiling, Duration elapsed);

void update_limits(const Config& config, Duration elapsed, State& state);

}  // namespace voltlap::bms
