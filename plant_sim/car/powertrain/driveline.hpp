// SPDX-License-Identifier: Apache-2.0
// Final drive: torque up, speed down, a loss in the direction of the power flow (reference study, 2016, Eq. 3.2). Its
// square brings the rotor's inertia to the wheels.
#pragma once
#include "car/powertrain/motor.hpp"
#include "core/axle_motors.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Torque at the wheels [Nm] for a torque at the motor shaft that drives (or is driven by) the wheels.
[[nodiscard]] inline double wheel_torque(const PowertrainSection& p, double shaft_torque_nm, bool driving) {
  return shaft_torque_nm * p.final_drive * (driving ? p.driveline_efficiency : 1.0 / p.driveline_efficiency);
}

/// Heat [W] of the driveline that carries the shaft power `shaft_power_w`.
[[nodiscard]] inline double driveline_loss(const PowertrainSection& p, double shaft_power_w, bool driving) {
  return shaft_power_w * (driving ? 1.0 - p.driveline_efficiency : 1.0 - 1.0 / p.driveline_efficiency);
}

/// Of `count` rotors [kg m2], at the wheels.
[[nodiscard]] inline double rotor_inertia(const VehicleParameters& car, int count) {
  const double gear = car.powertrain.final_drive;
  return count * car.motor.rotor_inertia_kg_m2 * gear * gear;
}

/// All that turns with the rear wheels [kg m2], there.
[[nodiscard]] inline double driveline_inertia(const VehicleParameters& car) {
  return car.powertrain.driveline_inertia_kg_m2 + rotor_inertia(car, driving_axles(car.powertrain).rear.count);
}

/// All that turns with the front wheels [kg m2], there.
[[nodiscard]] inline double front_axle_inertia(const VehicleParameters& car) {
  return car.vehicle.front_axle_inertia_kg_m2 + rotor_inertia(car, driving_axles(car.powertrain).front.count);
}

/// All that turns with the driven wheels [kg m2], there.
[[nodiscard]] inline double driven_inertia(const VehicleParameters& car) {
  return driveline_inertia(car) + (car.powertrain.motors == 1 ? 0.0 : front_axle_inertia(car));
}

/// Forces [N] with which the drag of the motors holds back a car that coasts.
struct CoastingDrag {
  double front_n = 0.0, rear_n = 0.0;
  [[nodiscard]] double sum_n() const { return front_n + rear_n; }
};

/// At wheels of a radius that roll.
[[nodiscard]] inline CoastingDrag coasting_drag(const VehicleParameters& car, double speed_mps, double radius_m) {
  if (car.powertrain.kind != "electric") return {};
  const double drag = motor_drag(car.motor, speed_mps / radius_m * car.powertrain.final_drive);
  const double each = wheel_torque(car.powertrain, drag, false) / radius_m;
  const DrivenAxles axles = driving_axles(car.powertrain);
  return {axles.front.count * each, axles.rear.count * each};
}

}  // namespace voltlap::plant
