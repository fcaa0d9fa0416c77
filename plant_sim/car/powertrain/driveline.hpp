// SPDX-License-Identifier: Apache-2.0
// Final drive: torque up, speed down, a loss in the direction of the power flow (reference study, 2016, Eq. 3.2). Its
// square brings the rotor's inertia to the wheels.
#pragma once
#include "car/powertrain/motor.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Torque at the rear wheels [Nm] for a torque at the motor shaft that drives (or is driven by) the wheels.
[[nodiscard]] inline double wheel_torque(const PowertrainSection& p, double shaft_torque_nm, bool driving) {
  return shaft_torque_nm * p.final_drive * (driving ? p.driveline_efficiency : 1.0 / p.driveline_efficiency);
}

/// Heat [W] of the driveline that carries the shaft power `shaft_power_w`.
[[nodiscard]] inline double driveline_loss(const PowertrainSection& p, double shaft_power_w, bool driving) {
  return shaft_power_w * (driving ? 1.0 - p.driveline_efficiency : 1.0 - 1.0 / p.driveline_efficiency);
}

/// All that turns with the rear wheels [kg m2], there.
[[nodiscard]] inline double driveline_inertia(const VehicleParameters& car) {
  const double gear = car.powertrain.final_drive;
  return car.powertrain.driveline_inertia_kg_m2 + car.motor.rotor_inertia_kg_m2 * gear * gear;
}

/// Force [N] with which the drag of the motor holds back a car that coasts, at wheels of a radius that roll.
[[nodiscard]] inline double coasting_drag(const VehicleParameters& car, double speed_mps, double radius_m) {
  if (car.powertrain.kind != "electric") return 0.0;
  const double drag = motor_drag(car.motor, speed_mps / radius_m * car.powertrain.final_drive);
  return wheel_torque(car.powertrain, drag, false) / radius_m;
}

}  // namespace voltlap::plant
