// SPDX-License-Identifier: Apache-2.0
// What the tyres can hold, the same for the lap solver, the road and the driver: a friction ellipse.
//
//   mu = D (its peak)      a_y,max = mu_y (g + downforce / m), and no wheel lifted
//   (F_x / mu N)^2 + (a_y / a_y,grip)^2 <= 1
// Source: Milliken & Milliken, Race Car Vehicle Dynamics, 1995, chapter 2; wheel lift: reference study, 2016,
// Eq. 3.10-3.15.
#pragma once
#include <algorithm>
#include <cmath>

#include "car/powertrain/driveline.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/chassis.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Peak longitudinal force over normal force: D, or less of it where the curve's shape never reaches its crest.
[[nodiscard]] inline double peak_friction(const TyreSection& tyre) {
  const double inner = tyre.pacejka_e < 1.0 ? M_PI / 2.0 : std::atan(M_PI / 2.0);
  return tyre.pacejka_d * std::sin(std::min(M_PI / 2.0, tyre.pacejka_c * inner));
}

[[nodiscard]] inline double lateral_friction(const TyreSection& tyre) {
  return peak_friction(tyre) * tyre.lateral_grip;
}

/// Lateral acceleration [m/s2] that takes all of the tyres' grip.
[[nodiscard]] inline double lateral_grip(const VehicleParameters& car, double airspeed_mps) {
  constexpr double kLeast_mps2 = 1e-3;  // a car that lifts off has no grip, and is divided by it
  return std::max(kLeast_mps2, lateral_friction(car.tyres) * (car.environment.gravity_mps2 +
                                                              downforce(car, airspeed_mps) / total_mass(car)));
}

/// Lateral acceleration [m/s2] at which the inner wheel of an axle lifts. Which axle is the first depends on the speed.
struct AxleLift {
  double front_mps2, rear_mps2;
};

[[nodiscard]] inline AxleLift axle_lift(const VehicleParameters& car, double airspeed_mps) {
  const double mass = total_mass(car), rear = car.vehicle.cg_rear_fraction, h = car.vehicle.cg_height_m;
  const double weight = mass * car.environment.gravity_mps2, press = downforce(car, airspeed_mps) / 4.0;
  return {(weight * (1.0 - rear) / 2.0 + press) / (mass * (1.0 - rear) * h) * car.vehicle.track_front_m,
          (weight * rear / 2.0 + press) / (mass * rear * h) * car.vehicle.track_rear_m};
}

/// Lateral acceleration [m/s2] at which the first wheel lifts.
[[nodiscard]] inline double lateral_lift(const VehicleParameters& car, double airspeed_mps) {
  const AxleLift lift = axle_lift(car, airspeed_mps);
  return std::min(lift.front_mps2, lift.rear_mps2);
}

/// Share of the longitudinal grip that is left beside a lateral acceleration, 0..1.
[[nodiscard]] inline double longitudinal_share(double lateral_mps2, double lateral_grip_mps2) {
  const double used = lateral_mps2 / lateral_grip_mps2;
  return std::sqrt(std::max(0.0, 1.0 - used * used));
}

/// Greatest drive force [N] of the driven tyres with `share` of their grip, beside a resistance: the force itself loads
/// the rear ones, F = s mu (N + (F - resistance) h / L). Where the front axle drives too, with a share f of the force,
/// the first axle at its edge ends it: f F = s mu (N_f - (F - resistance) h / L), (1 - f) F = s mu (N_r + ...).
[[nodiscard]] inline double drive_grip(const VehicleParameters& car, double airspeed_mps, double share,
                                       double resistance_n) {
  const double friction = share * peak_friction(car.tyres);
  const double lever = friction * car.vehicle.cg_height_m / car.vehicle.wheelbase_m;
  const DrivenAxles axles = driving_axles(car.powertrain);
  const double front_share = axles.front.share, rear_share = axles.rear.share;
  const AxleLoads loads = axle_loads(car, 0.0, airspeed_mps);
  double most = 1e9;  // with a lever this long it would lift its front first
  if (lever < rear_share) most = (friction * loads.rear_n - lever * resistance_n) / (rear_share - lever);
  if (front_share > 0.0) {
    most = std::min(most, (friction * loads.front_n + lever * resistance_n) / (front_share + lever));
  }
  return std::max(0.0, most);
}

/// The brake pedal, 0..1, at which the first axle would lock, with `share` of the tyres' grip: p F_i = s mu N_i(p). The
/// tyres hold back `drag` beside their brakes.
[[nodiscard]] inline double locking_pedal(const VehicleParameters& car, double airspeed_mps, double share,
                                          double resistance_n, double radius_m, const CoastingDrag& drag = {}) {
  const BrakeTorques full = brake_torques(car.brakes, 1.0);
  const double front = full.front_nm / radius_m, rear = full.rear_nm / radius_m;
  const AxleLoads still = axle_loads(car, 0.0, airspeed_mps);
  const double friction = share * peak_friction(car.tyres);
  const double lever = friction * car.vehicle.cg_height_m / car.vehicle.wheelbase_m;  // load moved forward per force
  const double slowing = resistance_n + drag.sum_n();
  const double front_slope = front - lever * (front + rear), rear_slope = rear + lever * (front + rear);
  double pedal = 1.0;
  const double front_left = friction * still.front_n + lever * slowing - drag.front_n;
  if (front_slope > 0.0) pedal = std::min(pedal, front_left / front_slope);
  if (rear > 0.0) pedal = std::min(pedal, (friction * still.rear_n - lever * slowing - drag.rear_n) / rear_slope);
  return std::max(0.0, pedal);
}

}  // namespace voltlap::plant
