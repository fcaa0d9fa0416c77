// SPDX-License-Identifier: Apache-2.0
// Limits from the voltage now and one resistance:
//   discharge: I_max = min over the cells of I_k + (V_k - V_min) / R
//   charge:    I_max = min over the cells of (V_max - V_k) / R - I_k
// I_k, V_k: current and voltage of cell k, measured together, discharge positive; R: resistance of a cell. The first is
// Eq. 4.12 of the reference study.
#pragma once
#include "bms/limits/method.hpp"

namespace voltlap::bms {

void lower_discharge_by_equation(const Config& config, const State& state, Limit& limit);
void lower_charge_by_equation(const Config& config, const State& state, Limit& limit);

}  // namespace voltlap::bms
