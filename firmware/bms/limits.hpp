// SPDX-License-Identifier: Apache-2.0
// How much current the pack may give and take, and what sets it.
//   discharge: I_max = min over the cells of I_k + (V_k - V_min) / R
//   charge:    I_max = min over the cells of (V_max - V_k) / R - I_k
// I_k, V_k: current and voltage of cell k, measured together, discharge positive; R: resistance of a cell. The first is
// Eq. 4.12 of the reference study. Both are clipped at zero, at the maximum of the configuration and by temperature.
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
