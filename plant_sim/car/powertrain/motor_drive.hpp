// SPDX-License-Identifier: Apache-2.0
// An inverter and its motor: the one of the rear axle, or one of four at the wheels.
#pragma once
#include <cstddef>
#include <vector>

#include "car/powertrain/amk.hpp"
#include "car/powertrain/inverter.hpp"
#include "car/powertrain/motor.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

struct MotorDrive {
  explicit MotorDrive(const VehicleParameters& car, bool front_axle = false)
      : front(front_axle), inverter(car.inverter), amk(car.inverter),
        thermal(car.motor, car.environment.ambient_c) {}

  bool front;
  Inverter inverter;  ///< its current controller, whatever it is commanded by
  Amk amk;            ///< what stands before that in a car with inverter.protocol amk
  MotorThermal thermal;
  double current_a = 0.0;  ///< that flows
  double copper_heat_j = 0.0, steel_heat_j = 0.0;  ///< of the control period so far
};

inline constexpr std::size_t kMostDrives = 4;

/// Front left, front right, rear left, rear right; or the one.
[[nodiscard]] inline std::vector<MotorDrive> motor_drives(const VehicleParameters& car) {
  if (car.powertrain.motors == 1) return {MotorDrive(car)};
  return {MotorDrive(car, true), MotorDrive(car, true), MotorDrive(car), MotorDrive(car)};
}

}  // namespace voltlap::plant
