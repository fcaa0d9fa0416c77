// SPDX-License-Identifier: Apache-2.0
// What the firmware must know of a car, from the car's parameters. The BMS's capacity, OCV and resistance follow the
// plant's cell unless `bms.*` keys say otherwise: the BMS may then be wrong on purpose.
#pragma once
#include "bms/config.hpp"
#include "core/parameters.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

/// Throws InputError when the BMS's own check refuses the result.
[[nodiscard]] bms::Config bms_config(const VehicleParameters& car);

/// Throws InputError when the master controller's own check refuses the result.
[[nodiscard]] master::Config master_config(const VehicleParameters& car);

}  // namespace voltlap::plant
