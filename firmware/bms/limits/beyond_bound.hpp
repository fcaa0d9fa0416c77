// SPDX-License-Identifier: Apache-2.0
// A cell whose reading is beyond its bound has shown what it can do: as much of the current that took it there as its
// bound is of its drop.
//   I_most = I (OCV - V_bound) / (OCV - V)       OCV of its filter, I the current when V was read
// A filter believes a resistance that is three times its table's after a second; until then this holds. So that it is
// no limit of every step: readings alone, and for kHeldBeyond after the last.
// BMS-047
#pragma once
#include "bms/limits/method.hpp"

namespace voltlap::bms {

inline constexpr Duration kHeldBeyond = Duration::from_ms(1'000);  // chosen: the filter of each cell has had ten turns

/// After the filters; not on a charger, whose end of charge is a matter of its own.
void note_beyond_bound(const Config& config, State& state);

void lower_discharge_beyond_bound(const State& state, Limit& limit);
void lower_charge_beyond_bound(const State& state, Limit& limit);

}  // namespace voltlap::bms
