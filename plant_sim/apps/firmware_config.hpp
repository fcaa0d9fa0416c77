// SPDX-License-Identifier: Apache-2.0
// The firmware's configuration for a car: pack, limits and motor as the vehicle file tells them, rounded to the
// firmware's integers. The BMS's own idea of capacity and resistance follows the plant's unless `bms.*` keys say otherwise.
#pragma once
#include "bms/config.hpp"
#include "core/parameters.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

/// Throws InputError, with the keys to look at, when the firmware refuses the result.
[[nodiscard]] bms::Config bms_config(const VehicleParameters& car);
[[nodiscard]] master::Config master_config(const VehicleParameters& car);

}  // namespace voltlap::plant
