// SPDX-License-Identifier: Apache-2.0
// Spreads what is left in the pack over the distance that is left: with Config::energy_to_go_m the discharge limit
// falls early and little, where without it the last kilometres would be driven with nothing.
#pragma once
#include "base/time.hpp"
#include "bms/estimate/soc_record.hpp"
#include "bms/limits/limits_state.hpp"

namespace voltlap::bms {

struct State;
struct Limit;

/// Once a step, before the limits. After every 100 m of the motor's turns,
///   r = (SOC - reserve) / (pieces left) / (mean charge of the last pieces, about ten), within 0.5 and 1.5,
///   cap <- cap (1 + (r - 1) / 16), never below a tenth of what it began at.
/// The cap begins at the largest current of late with the first r below 1, and ends when r is above 1 with the cap a
/// quarter above that current, or at the maximum. A charge begins the distance anew.
void spread_charge(const Config& config, Duration elapsed, State& state);

/// BMS-048
void lower_discharge_by_energy(const State& state, Limit& limit);

/// Before the first step: how much of the distance had been driven when the record was written.
void restore_way(const SocRecord& record, EnergyToGo& way);

}  // namespace voltlap::bms
