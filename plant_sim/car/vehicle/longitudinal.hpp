// SPDX-License-Identifier: Apache-2.0
// The car along its path: two axles on slipping tyres, one of them driven or both, push a mass against drag and rolling
// resistance.
#pragma once
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/chassis.hpp"
#include "car/vehicle/tyre.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// What the road asks of the car beside the way ahead. All 0 on a level straight in still air.
struct Road {
  double lateral_mps2 = 0.0;        ///< that the tyres give, towards the inside
  double longitudinal_share = 1.0;  ///< of their grip, left for driving and braking
  double grade = 0.0;               ///< rise over distance, positive uphill
  double head_wind_mps = 0.0;       ///< positive from ahead
};

/// Work done in one step, joules, each from its own force and the mean speed of the step.
struct VehicleEnergy {
  double driveline_in_j = 0.0;   ///< torque at the wheels times their speed
  double kinetic_j = 0.0;        ///< change of translation and rotation
  double climb_j = 0.0, aero_j = 0.0, rolling_j = 0.0, cornering_j = 0.0, slip_j = 0.0;
  double front_brake_j = 0.0, rear_brake_j = 0.0;
};

/// At the wheels, both of an axle together [Nm], positive drives forward.
struct AxleTorques {
  double front_nm = 0.0, rear_nm = 0.0;
};

class LongitudinalVehicle {
 public:
  explicit LongitudinalVehicle(const VehicleParameters& car) : car_(car) {}

  /// One step under the drive torques and the brake pedal (0..1).
  VehicleEnergy advance(const AxleTorques& drive, double brake_pedal, double step_s);
  /// Driven at the rear wheels alone.
  VehicleEnergy advance(double drive_torque_nm, double brake_pedal, double step_s) {
    return advance(AxleTorques{0.0, drive_torque_nm}, brake_pedal, step_s);
  }

  /// Holds until the next call.
  void set_road(const Road& road);

  [[nodiscard]] double speed_mps() const { return speed_; }
  [[nodiscard]] double distance_m() const { return distance_; }
  [[nodiscard]] double acceleration_mps2() const { return acceleration_; }
  [[nodiscard]] double front_omega() const { return front_omega_; }
  [[nodiscard]] double rear_omega() const { return rear_omega_; }
  /// Over the last step.
  [[nodiscard]] double front_omega_mean() const { return front_omega_mean_; }
  [[nodiscard]] double rear_omega_mean() const { return rear_omega_mean_; }
  /// Sets the car rolling without slip.
  void set_speed(double speed_mps);

 private:
  const VehicleParameters& car_;
  Road road_;
  double speed_ = 0.0, distance_ = 0.0, acceleration_ = 0.0;
  double front_omega_ = 0.0, rear_omega_ = 0.0, front_omega_mean_ = 0.0, rear_omega_mean_ = 0.0;
};

}  // namespace voltlap::plant
