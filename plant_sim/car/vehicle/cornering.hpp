// SPDX-License-Identifier: Apache-2.0
// Forces along the path that a straight and level road does not have.
//
//   cornering: tyres that push sideways run at a slip angle, and their force leans back by it:
//              F = m a_y sin(alpha), alpha = m a_y / (C N) -> m a_y^2 / (C g)
//   climbing:  m g sin(atan(grade))
// The load of the tyres is taken as that of a level road (a grade of 10 % takes 0.5 % of it).
#pragma once
#include <cmath>

#include "car/vehicle/chassis.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Force [N] against the direction of travel; 0 without tyres.cornering_stiffness_per_rad. A standing car does not
/// corner.
[[nodiscard]] inline double cornering_drag(const VehicleParameters& car, double lateral_mps2) {
  const double stiffness = car.tyres.cornering_stiffness_per_rad;
  if (stiffness <= 0.0) return 0.0;
  return total_mass(car) * lateral_mps2 * lateral_mps2 / (stiffness * car.environment.gravity_mps2);
}

/// Force [N] against the direction of travel, positive uphill.
[[nodiscard]] inline double climbing_force(const VehicleParameters& car, double grade) {
  if (grade == 0.0) return 0.0;
  return total_mass(car) * car.environment.gravity_mps2 * grade / std::sqrt(1.0 + grade * grade);
}

}  // namespace voltlap::plant
