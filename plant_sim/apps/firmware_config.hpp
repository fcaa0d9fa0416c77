// SPDX-License-Identifier: Apache-2.0
// The firmware's configuration for a car: pack, limits and motor as the vehicle file tells them, to the nearest of the
// firmware's integers. The BMS's own idea of capacity, OCV and resistance follows the plant's unless `bms.*` keys say
// otherwise.
#pragma once
#include "apps/firmware_refusal.hpp"
#include "bms/config.hpp"
#include "core/parameters.hpp"
#include "master/config.hpp"
#include "race/sensors/pedal_sensors.hpp"

namespace voltlap::plant {

/// Throws InputError, with the one condition that fails, when the firmware refuses the result; `origins` says where
/// the car's values stand.
[[nodiscard]] bms::Config bms_config(const VehicleParameters& car, const Origins& origins = {});
[[nodiscard]] master::Config master_config(const VehicleParameters& car, const Origins& origins = {});

/// The pedal box that a master controller with this configuration expects.
[[nodiscard]] PedalSensors pedal_sensors(const master::Config& config);

/// How far the firmware's integers and straight lines are from the cell's curves.
struct TableRounding {
  double ocv_points_v = 0.0;                            ///< at the points: rounding
  int ocv_raised_points = 0;                            ///< plateaus that had to rise by a step a point ...
  double ocv_raised_v = 0.0;                            ///< ... and by how much, at most
  double ocv_between_v = 0.0, ocv_between_soc = 0.0;    ///< between them: largest, and where
  double soc_per_mv = 0.0, soc_per_mv_at = 0.0;         ///< most that a millivolt of reading moves it
  double resistance_points_share = 0.0;                 ///< relative rounding of the resistances, largest
};
/// Throws InputError when a table does not fit into the firmware's numbers: a resistance of a few microohms, a curve
/// so flat that no state of charge can be read from it.
[[nodiscard]] TableRounding table_rounding(const VehicleParameters& car, const bms::Config& config);

}  // namespace voltlap::plant
