// SPDX-License-Identifier: Apache-2.0
// Which cells are discharged through their shunt: those that stand too high in the last look at rest.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// Some cell of the last look may be bled.
[[nodiscard]] bool some_to_bleed(const Config& config, const CellLook& look);
/// Too hot for shunts, which warm the cells beside them.
[[nodiscard]] bool too_hot_to_bleed(const Config& config, const State& state);

/// A shunt is asked for in the phase of bleeding alone, for a cell above config.balancing_voltage_min and more than
/// half of config.balancing_difference above the lowest, and above the floor of the look: the other
/// half is for what the next charge makes of it.
void request_balancing(const Config& config, State& state);

}  // namespace voltlap::bms
