// SPDX-License-Identifier: Apache-2.0
// Aerodynamic drag and downforce: F = 1/2 C A rho V^2 (reference study, 2016, Eq. 4.9 and 4.10; its "lift" presses the
// car down). Only the product C A is known of that car: 0.372 m2.
#pragma once
#include <cmath>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Drag [N] against the direction of travel, signed with V.
[[nodiscard]] inline double drag_force(const VehicleParameters& car, double speed_mps) {
  return 0.5 * car.aero.drag_coefficient * car.aero.frontal_area_m2 * car.environment.air_density_kg_per_m3 *
         speed_mps * std::abs(speed_mps);
}

/// Downforce [N] on the whole car, positive presses it down.
[[nodiscard]] inline double downforce(const VehicleParameters& car, double speed_mps) {
  return 0.5 * car.aero.downforce_coefficient * car.aero.frontal_area_m2 * car.environment.air_density_kg_per_m3 *
         speed_mps * speed_mps;
}

}  // namespace voltlap::plant
