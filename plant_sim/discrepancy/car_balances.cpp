// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/car_balances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "powertrain/driveline.hpp"
#include "powertrain/inverter.hpp"
#include "powertrain/motor.hpp"
#include "vehicle/aero.hpp"
#include "vehicle/brakes.hpp"
#include "vehicle/chassis.hpp"
#include "vehicle/rolling_resistance.hpp"
#include "vehicle/tyre.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kRpm = 2.0 * 3.14159265358979323846 / 60.0;  // rad/s
constexpr double kSlopeWindow = 0.25;   // s on each side, of the acceleration
constexpr double kMoving = 2.0;         // m/s; below it neither slip nor force is judged

const VectorXd* pack_voltage(const Recording& log) {
  for (const char* role : {"pack_voltage", "bus_voltage"}) {
    if (const VectorXd* found = log.find(role)) return found;
  }
  return nullptr;
}

bool has_torque(const Recording& log) { return log.find("motor_torque") || log.find("accelerator"); }

/// Slope of a straight line through the rows within the window.
VectorXd slope_of(const VectorXd& time, const VectorXd& values) {
  VectorXd out(values.size());
  Index first = 0, last = 0;
  for (Index row = 0; row < values.size(); ++row) {
    while (time(row) - time(first) > kSlopeWindow + 1e-6) ++first;
    while (last + 1 < values.size() && time(last + 1) - time(row) <= kSlopeWindow + 1e-6) ++last;
    const Index n = last - first + 1;
    const auto t = time.segment(first, n).array() - time.segment(first, n).mean();
    out(row) = n > 1 ? (t * values.segment(first, n).array()).sum() / t.square().sum()
                     : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

/// Mean over the same window, so that what drives the acceleration is smoothed as it is.
VectorXd smoothed(const VectorXd& time, const VectorXd& values) {
  VectorXd out(values.size());
  Index first = 0, last = 0;
  for (Index row = 0; row < values.size(); ++row) {
    while (time(row) - time(first) > kSlopeWindow + 1e-6) ++first;
    while (last + 1 < values.size() && time(last + 1) - time(row) <= kSlopeWindow + 1e-6) ++last;
    out(row) = values.segment(first, last - first + 1).mean();
  }
  return out;
}

/// Motor torque at the shaft, as it really is in this world.
VectorXd torque_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const MotorSection& motor = world.car.motor;
  VectorXd out(log.rows());
  if (const VectorXd* measured = log.find("motor_torque")) {
    out = *measured;
  } else {
    const VectorXd& pedal = *log.find("accelerator");
    const VectorXd* speed = log.find("motor_speed");
    for (Index row = 0; row < log.rows(); ++row) {
      const double omega = speed != nullptr ? (*speed)(row) * kRpm : 0.0;
      const double base = motor.curve_torque_nm.front(), at = omega / kRpm / (1.0 + world.base_speed_change);
      double most = base;
      for (std::size_t k = 1; k < motor.curve_speed_rpm.size(); ++k) {
        const double x0 = motor.curve_speed_rpm[k - 1], x1 = motor.curve_speed_rpm[k];
        if (at < x0) break;
        const double part = std::clamp((at - x0) / (x1 - x0), 0.0, 1.0);
        most = motor.curve_torque_nm[k - 1] + part * (motor.curve_torque_nm[k] - motor.curve_torque_nm[k - 1]);
      }
      out(row) = std::min(motor_torque(motor, pedal(row) * world.car.inverter.current_max_a, 1.0), most);
    }
  }
  return out * (1.0 + world.torque_change);
}

/// Kelvin above ambient of the winding, from the model's losses.
VectorXd winding_above_ambient(const World& world, const Comparison& comparison, const VectorXd& torque) {
  const Recording& log = comparison.log;
  const VectorXd* speed = log.find("motor_speed");
  MotorThermal thermal(world.car.motor, 0.0);
  VectorXd out = VectorXd::Zero(log.rows());
  for (Index row = 1; row < log.rows(); ++row) {
    const double dt = std::min(1.0, log.time_s(row) - log.time_s(row - 1));
    const MotorSection& m = world.car.motor;
    const double current = std::isfinite(torque(row)) ? torque(row) / m.constant_nm_per_a : 0.0;
    const double omega = speed != nullptr && std::isfinite((*speed)(row)) ? (*speed)(row) * kRpm : 0.0;
    double heat = std::abs(motor_loss(m, current, omega, current * omega >= 0.0));
    if (!m.winding_loss) heat += m.winding_resistance_ohm * current * current;
    for (int part = 0; part < 20; ++part) thermal.advance(heat * dt / 20, dt / 20, 0.0);
    out(row) = thermal.copper_c();
  }
  return out;
}

VectorXd warmed_torque(const World& world, const Comparison& comparison) {
  VectorXd torque = torque_of(world, comparison);
  if (world.torque_per_k == 0.0) return torque;
  const VectorXd warm = winding_above_ambient(world, comparison, torque);
  return (torque.array() * (1.0 - world.torque_per_k * warm.array())).matrix();
}

VectorXd power_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const MotorSection& m = world.car.motor;
  const Inverter inverter(world.car.inverter);
  const VectorXd torque = warmed_torque(world, comparison), &speed = *log.find("motor_speed");
  const VectorXd& volts = *pack_voltage(log);
  VectorXd out(log.rows());
  for (Index row = 0; row < log.rows(); ++row) {
    const double omega = speed(row) * kRpm, mechanical = torque(row) * omega;
    const double eta = mechanical >= 0.0 ? m.efficiency : 1.0 / m.efficiency;
    const double phase = torque(row) / (m.constant_nm_per_a * eta);
    const double motor_w = motor_power(m, phase, omega);
    const double true_w =
        inverter.dc_power(motor_w) + world.loss_change * inverter.loss(motor_w) + world.car.low_voltage.power_w;
    out(row) = true_w * (1.0 + world.current.gain) + volts(row) * world.current.offset;
  }
  return world.current.delay_s != 0.0 ? shifted(log.time_s, out, -world.current.delay_s) : out;
}

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
    const BrakeTorques t = brake_torques(car.brakes, (*pedal)(row));
    const double front = t.front_nm / car.tyres.radius_m * (1.0 - world.friction_per_k * rotors.front_c()),
                 rear = t.rear_nm / car.tyres.radius_m * (1.0 - world.friction_per_k * rotors.rear_c());
    const double most = car.tyres.pacejka_d * (1.0 + world.grip_change) * total_mass(car) *
                        car.environment.gravity_mps2;
    out(row) = v > kMoving ? std::min(front + rear, most) : 0.0;
    rotors.advance(front * v * dt, rear * v * dt, dt, 0.0);
  }
  return out;
}

VectorXd drive_force(const World& world, const Comparison& comparison) {
  const VectorXd torque = warmed_torque(world, comparison);
  VectorXd out(torque.size());
  for (Index row = 0; row < torque.size(); ++row) {
    out(row) = wheel_torque(world.car.powertrain, torque(row), torque(row) >= 0.0) / world.car.tyres.radius_m;
  }
  return out;
}

/// Force that would give the recorded acceleration to the model's mass, so that a change of mass shows.
VectorXd force_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VehicleParameters& car = world.car;
  const VectorXd &speed = *log.find("speed"), brakes = brake_force(world, comparison),
                 drive = drive_force(world, comparison);
  VectorXd out(log.rows());
  const double r = car.tyres.radius_m, mass = total_mass(car);
  const double inertia = (car.vehicle.front_axle_inertia_kg_m2 + car.powertrain.driveline_inertia_kg_m2) / (r * r);
  for (Index row = 0; row < log.rows(); ++row) {
    const double v = speed(row);
    double force = drive(row) - drag_force(car, v + world.wind_mps) - rolling_force(car, v) -
                   mass * car.environment.gravity_mps2 * world.slope - brakes(row);
    if ((*log.find("speed"))(row) < kMoving) force = std::numeric_limits<double>::quiet_NaN();
    out(row) = force / (mass + inertia);
  }
  return smoothed(log.time_s, out);
}

VectorXd motor_speed_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VehicleParameters& car = world.car;
  const VectorXd &speed = *log.find("speed"), drive = drive_force(world, comparison);
  const double normal = total_mass(car) * car.environment.gravity_mps2 * car.vehicle.cg_rear_fraction;
  const double stiffness = tyre_force(car.tyres, 0.0, normal).slope_n;
  VectorXd out(log.rows());
  for (Index row = 0; row < log.rows(); ++row) {
    const double v = speed(row), slip = drive(row) / stiffness * (1.0 + world.slip_change);
    out(row) = v > kMoving ? v * (1.0 + slip) * car.powertrain.final_drive / car.tyres.radius_m / kRpm
                           : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

}  // namespace

std::vector<BalanceChannel> car_channels(const World& model, const Recording& log) {
  if (model.car.tyres.radius_m <= 0.0) return {};
  std::vector<BalanceChannel> out;
  const VectorXd *volts = pack_voltage(log), *speed = log.find("speed"), *motor = log.find("motor_speed");
  if (has_torque(log) && motor != nullptr && volts != nullptr) {
    out.push_back({"power", Balance::kPower, "W", volts->cwiseProduct(*log.find("current"))});
  }
  if (has_torque(log) && speed != nullptr) {
    out.push_back({"speed", Balance::kForce, "m/s2", slope_of(log.time_s, *speed)});
  }
  if (motor != nullptr && speed != nullptr && has_torque(log)) {
    out.push_back({"motor_speed", Balance::kForce, "rpm", *motor});
  }
  return out;
}

VectorXd car_prediction(const std::string& channel, const World& world, const Comparison& comparison,
                        const BatteryResponse&) {
  if (channel == "power") return power_of(world, comparison);
  if (channel == "speed") return force_of(world, comparison);
  return motor_speed_of(world, comparison);
}

}  // namespace voltlap::plant
