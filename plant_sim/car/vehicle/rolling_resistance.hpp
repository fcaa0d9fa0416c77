// SPDX-License-Identifier: Apache-2.0
// Rolling resistance C_R m g, against the direction of travel (reference study, 2016, Eq. 3.4 and Table A.1).
#pragma once
#include <algorithm>

#include "car/vehicle/chassis.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Force [N], signed with V. Below 0.05 m/s it falls linearly to zero, so that a standing car is not pushed.
[[nodiscard]] inline double rolling_force(const VehicleParameters& car, double speed_mps) {
  constexpr double kFadeSpeed = 0.05;
  return car.tyres.rolling_resistance * total_mass(car) * car.environment.gravity_mps2 *
         std::clamp(speed_mps / kFadeSpeed, -1.0, 1.0);
}

}  // namespace voltlap::plant
