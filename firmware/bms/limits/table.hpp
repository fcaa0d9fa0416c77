// SPDX-License-Identifier: Apache-2.0
// Limits as a battery unit with tables sets them, an Orion BMS for one: a share of the maximum by temperature and by
// state of charge, whatever the cells are like, and a cap that falls while a cell stands beyond its bound and comes
// back slowly. It needs no resistance, and knows of a weak cell only when that has been too low already.
#pragma once
#include "bms/limits/method.hpp"

namespace voltlap::bms {

/// Moves the caps, once a step.
void follow_caps(const Config& config, Duration elapsed, State& state);

void lower_discharge_by_table(const Config& config, const State& state, Limit& limit);
void lower_charge_by_table(const Config& config, const State& state, Limit& limit);

}  // namespace voltlap::bms
