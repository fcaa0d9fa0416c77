// SPDX-License-Identifier: Apache-2.0
// What needs the cell's tables and cannot be said by core/parameter_check.hpp: whether the motor bears the pack.
#pragma once
#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// Throws InputError when the pack, full and open, has more than motor.voltage_max_v. A car without an electric motor,
/// or whose motor states none, bears any.
void check_motor_voltage(const LoadedVehicle& vehicle);

}  // namespace voltlap::plant
