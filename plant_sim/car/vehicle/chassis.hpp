// SPDX-License-Identifier: Apache-2.0
// Mass and load transfer: what each axle carries (reference study, 2016, Eq. 3.8, 3.11-3.14 and 4.11).
#pragma once
#include <algorithm>

#include "car/vehicle/aero.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Of the pack [kg]: its cells, and what holds them.
[[nodiscard]] inline double pack_mass(const VehicleParameters& car) {
  return car.battery.cells_in_series * car.battery.cells_in_parallel * car.cell.mass_kg * car.battery.mass_over_cells;
}

/// Car and driver [kg]. As weighed, or with a pack that weighs what its cells weigh.
[[nodiscard]] inline double total_mass(const VehicleParameters& car) {
  const VehicleSection& v = car.vehicle;
  return (v.mass_kg > 0.0 ? v.mass_kg : v.mass_without_pack_kg + pack_mass(car)) + v.driver_mass_kg;
}

struct AxleLoads {
  double front_n;  ///< both front tyres
  double rear_n;   ///< both rear tyres
};

/// Normal forces under longitudinal acceleration (positive: speeding up loads the rear). A lifted axle carries 0.
[[nodiscard]] inline AxleLoads axle_loads(const VehicleParameters& car, double acceleration_mps2, double speed_mps) {
  const double weight = total_mass(car) * car.environment.gravity_mps2;
  const double transfer = total_mass(car) * acceleration_mps2 * car.vehicle.cg_height_m / car.vehicle.wheelbase_m;
  const double half_downforce = 0.5 * downforce(car, speed_mps);
  return {std::max(0.0, weight * (1.0 - car.vehicle.cg_rear_fraction) - transfer + half_downforce),
          std::max(0.0, weight * car.vehicle.cg_rear_fraction + transfer + half_downforce)};
}

}  // namespace voltlap::plant
