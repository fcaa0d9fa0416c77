// SPDX-License-Identifier: Apache-2.0
// Which cells should be discharged through their shunt: a request a cell, nothing more.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// A cell is asked for when the pack rests and the cell stands above config.balancing_voltage_min and more than
/// config.balancing_difference above the weakest. Never with the shutdown circuit open (EV.7.3) or with a fault.
void request_balancing(const Config& config, State& state);

}  // namespace voltlap::bms
