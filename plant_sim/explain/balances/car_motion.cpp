// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/car_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/powertrain/driveline.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/chassis.hpp"
#include "car/vehicle/cornering.hpp"
#include "car/vehicle/grip.hpp"
#include "car/vehicle/rolling_resistance.hpp"
#include "car/vehicle/tyre.hpp"
#include "explain/balances/recorded_motor.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// Friction brakes' force on the car, with what their heat takes from it.
VectorXd brake_force(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VectorXd &speed = *log.find("speed"), *pedal = log.find("brake");
  VectorXd out = VectorXd::Zero(log.rows());
  if (pedal == nullptr) return out;
  const VehicleParameters& car = world.car;
  BrakeRotors rotors(car.brakes, 0.0);
  for (Index row = 1; row < log.rows(); ++row) {
    const double dt = std::min(1.0, log.time_s(row) - log.time_s(row - 1)), v = speed(row);
    if (!std::isfinite((*pedal)(row)) || !std::isfinite(v)) continue;
    const BrakeTorques t = brake_torques(car.brakes, (*pedal)(row) > kTouch ? (*pedal)(row) : 0.0);
    const double front = t.front_nm / car.tyres.radius_m * (1.0 + world.friction_per_k * rotors.front_c()),
                 rear = t.rear_nm / car.tyres.radius_m * (1.0 + world.friction_per_k * rotors.rear_c());
    const double most =
        car.tyres.pacejka_d * (1.0 + world.grip_change) * total_mass(car) * car.environment.gravity_mps2;
    out(row) = v > kMoving ? std::min(front + rear, most) : 0.0;
    rotors.advance(front * v * dt, rear * v * dt, dt, 0.0);
  }
  return out;
}

VectorXd drive_force(const World& world, const Comparison& comparison) {
  const VectorXd torque = true_torque(world, comparison, reported_torque(world, comparison));
  const VectorXd* speed = comparison.log.find("motor_speed");
  VectorXd out(torque.size());
  for (Index row = 0; row < torque.size(); ++row) {
    const double omega = speed != nullptr && std::isfinite((*speed)(row)) ? (*speed)(row)*kRpm : 0.0;
    const double shaft = torque(row) - motor_drag(world.car.motor, omega);
    out(row) = wheel_torque(world.car.powertrain, shaft, shaft >= 0.0) / world.car.tyres.radius_m;
  }
  return out;
}

/// What the car does [m/s2] by the forces on it, beside its brakes', each a force by row [N].
class Road {
 public:
  Road(const World& world, const Recording& log)
      : world_(world),
        speed_(*log.find("speed")),
        lateral_(log.find("lateral_acceleration")),
        mass_(total_mass(world.car)),
        climb_n_(mass_ * world.car.environment.gravity_mps2 * world.slope) {
    const double r = world.car.tyres.radius_m;
    driven_kg_ = driveline_inertia(world.car) / (r * r);
    turning_kg_ = driven_kg_ + front_axle_inertia(world.car) / (r * r);
  }
  [[nodiscard]] double acceleration(Index row, double drive_n, double brakes_n) const {
    const double v = speed_(row);
    const double corners_n = lateral_ != nullptr ? cornering_drag(world_.car, (*lateral_)(row)) : 0.0;
    const double force_n = drive_n - drag_force(world_.car, v + world_.wind_mps) - rolling_force(world_.car, v) -
                           climb_n_ - brakes_n - corners_n;
    return force_n / (mass_ + turning_kg_);
  }
  /// Of all that is to be sped up, what turns with the driven wheels.
  [[nodiscard]] double share_of_driven() const { return driven_kg_ / (mass_ + turning_kg_); }
  /// Of the tyres' grip along the road, what a corner leaves.
  [[nodiscard]] double grip_share(Index row) const {
    constexpr double kLeast = 1e-3;
    if (lateral_ == nullptr || !std::isfinite((*lateral_)(row))) return 1.0;
    return std::max(kLeast, longitudinal_share((*lateral_)(row), lateral_grip(world_.car, speed_(row))));
  }
  /// Of the drive, what the tyres pass to the road: the rest is taken by what turns with them.
  [[nodiscard]] double passed(double drive_n, double acceleration) const {
    return drive_n - driven_kg_ * acceleration;
  }

 private:
  const World& world_;
  const VectorXd& speed_;
  const VectorXd* lateral_;
  double mass_, climb_n_, driven_kg_ = 0.0, turning_kg_ = 0.0;
};

/// Slip that this part of the peak force takes. Grip is the peak: how stiff a tyre is at no slip stays.
double slip_at(const TyreSection& tyre, double force_n, double normal_n, double grip) {
  constexpr double kMost = 0.97;  // of the peak; beyond it no slip is steady
  const double used = std::clamp(force_n / (normal_n * tyre.pacejka_d * grip), -kMost, kMost);
  double inner = std::tan(std::asin(used) / tyre.pacejka_c), stiff = inner;
  for (int round = 0; round < 3; ++round) {  // inner = x - E (x - atan x), x = B k
    stiff = (inner - tyre.pacejka_e * std::atan(stiff)) / (1.0 - tyre.pacejka_e);
  }
  return stiff * grip / tyre.pacejka_b;
}

}  // namespace

VectorXd acceleration_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VectorXd brakes = brake_force(world, comparison), drive = drive_force(world, comparison);
  const Road road(world, log);
  VectorXd out(log.rows());
  for (Index row = 0; row < log.rows(); ++row) out(row) = road.acceleration(row, drive(row), brakes(row));
  return out;
}

VectorXd spun_up(const World& world, const Recording& log) {
  const VectorXd *motor = log.find("motor_speed"), &speed = *log.find("speed");
  if (motor == nullptr) return {};
  const double per_rpm = kRpm * world.car.tyres.radius_m / world.car.powertrain.final_drive;  // m/s at the wheel
  const double share = Road(world, log).share_of_driven();
  VectorXd out = VectorXd::Zero(log.rows());
  for (Index row = 1; row < log.rows(); ++row) {
    const double faster = per_rpm * ((*motor)(row) - (*motor)(row - 1)) - (speed(row) - speed(row - 1));
    if (std::isfinite(faster)) out(row) = -share * faster;
  }
  return out;
}

VectorXd motor_speed_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VehicleParameters& car = world.car;
  const VectorXd &speed = *log.find("speed"), drive = drive_force(world, comparison);
  const Road road(world, log);
  VectorXd out = VectorXd::Constant(log.rows(), kNothing);
  for (Index row = 0; row < log.rows(); ++row) {
    if (!(speed(row) > kMoving)) continue;
    const double gained = road.acceleration(row, drive(row), 0.0), force = road.passed(drive(row), gained);
    const double normal = road.grip_share(row) * axle_loads(car, gained, speed(row)).rear_n;
    const double slip = slip_at(car.tyres, force, normal, 1.0 + world.grip_change) * (1.0 + world.slip_change);
    out(row) = speed(row) * (1.0 + slip) * car.powertrain.final_drive / car.tyres.radius_m / kRpm;
  }
  return out;
}

}  // namespace voltlap::plant
