// SPDX-License-Identifier: Apache-2.0
// The charge, from the switch of the charger to full and even cells.
//
//   waiting   why not yet is told; then the contactors are closed through the precharge
//   charging  I = min(limit of the pack, hold, charger); the hold keeps the highest cell at charge_voltage():
//             d hold/dt = (V_charge - V_highest) / (R tau), tau 20 s, 4 s when it falls; ends below
//             config.charge_current_end
//   resting   charger and shunts off for 20 s, then the cells are looked at
//   bleeding  120 s of shunts; then another rest
//   full      after a charge the cells are within config.balancing_difference: the contactors open
//   stopped   something ended it, by name. Only the switch begins again, after full too.
// What ends a charge is the hold, never the current that flows: a small charger gives less than it is asked for, and no
// cell is full for that.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// Before the contactors, which follow it in the same step; `slow`: ten times a second.
void run_charge(const Config& config, Instant now, Duration elapsed, bool slow, State& state);

}  // namespace voltlap::bms
