// SPDX-License-Identifier: Apache-2.0
// Voltages that are read more seldom than the current, such as cells one after the other on a bus, are compared at the
// time at which each was read:  v_n(t) = recorded_n(t - age_n) + V(t) - V(t - age_n), V: the model's cell voltage.
// Held without this, all cells would follow the current half a scan late, and a sound log would show a slow cell.
#pragma once
#include "discrepancy/model.hpp"
#include "discrepancy/recording.hpp"

namespace voltlap::plant {

void bring_to_rows(Recording& log, const Model& model);

}  // namespace voltlap::plant
