// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/recorded_motor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/powertrain/motor.hpp"
#include "car/powertrain/torque_curve.hpp"
#include "explain/balances/car_balances.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Speed [rad/s] from which the torque falls; infinite if it never does.
double base_speed(const MotorSection& m) {
  for (std::size_t k = 1; k < m.curve_speed_rpm.size(); ++k) {
    if (m.curve_torque_nm[k] >= m.curve_torque_nm.front()) continue;
    // Beyond it the power is constant: it lies where that power meets the full torque.
    return m.curve_torque_nm[k] * m.curve_speed_rpm[k] / m.curve_torque_nm.front() * kRpm;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

VectorXd winding_above_ambient(const World& world, const Comparison& comparison, const VectorXd& torque) {
  constexpr double kStep_s = 0.05;  // the quickest mode of the chain is about 0.2 s
  const Recording& log = comparison.log;
  const VectorXd* speed = log.find("motor_speed");
  const MotorSection& m = world.car.motor;
  const double ambient_c = world.car.environment.ambient_c;
  MotorThermal thermal(m, 0.0);
  VectorXd out = VectorXd::Zero(log.rows());
  for (Index row = 1; row < log.rows(); ++row) {
    const double dt = std::min(1.0, log.time_s(row) - log.time_s(row - 1));
    const double current = std::isfinite(torque(row)) ? torque(row) / m.constant_nm_per_a : 0.0;
    const double omega = speed != nullptr && std::isfinite((*speed)(row)) ? (*speed)(row)*kRpm : 0.0;
    double heat =
        std::abs(motor_loss(m, current, omega, current * omega >= 0.0, ambient_c + thermal.copper_c()));
    if (!m.winding_loss) heat += m.winding_resistance_ohm * current * current;
    const double steel = motor_drag(m, omega) * omega;
    const auto parts = std::max(1, static_cast<int>(std::ceil(dt / kStep_s)));
    for (int part = 0; part < parts; ++part) thermal.advance(heat * dt / parts, dt / parts, 0.0, steel * dt / parts);
    out(row) = thermal.copper_c();
  }
  return out;
}

double weakening_loss(const World& world, double omega) {
  constexpr double kShare = 0.1;  // at twice the base speed, of the copper loss at full current; assumed
  if (world.base_speed_change == 0.0) return 0.0;
  const MotorSection& m = world.car.motor;
  const double full = kShare * m.winding_resistance_ohm * std::pow(world.car.inverter.current_max_a, 2);
  const double base = base_speed(m), changed = base * (1.0 + world.base_speed_change);
  const auto loss = [&](double from) { return full * std::pow(std::max(0.0, std::abs(omega) / from - 1.0), 2); };
  return loss(changed) - loss(base);
}

VectorXd torque_of_pedal(const World& world, const Recording& log) {
  const MotorSection& motor = world.car.motor;
  const TorqueCurve curve(motor);
  const VectorXd& pedal = *log.find("accelerator");
  const VectorXd *speed = log.find("motor_speed"), *volts = pack_voltage(log);
  VectorXd out(log.rows());
  for (Index row = 0; row < log.rows(); ++row) {
    const double omega = speed != nullptr ? (*speed)(row)*kRpm : 0.0;
    const double current = curve.current(pedal(row) * world.car.inverter.current_max_a,
                                         omega / (1.0 + world.base_speed_change),
                                         volts != nullptr ? (*volts)(row) : motor.curve_voltage_v);
    out(row) = motor_torque(motor, current, omega);
  }
  return out;
}

VectorXd reported_torque(const World& world, const Comparison& comparison) {
  const VectorXd* measured = comparison.log.find("motor_torque");
  return measured != nullptr ? *measured : torque_of_pedal(world, comparison.log);
}

VectorXd true_torque(const World& world, const Comparison& comparison, const VectorXd& reported) {
  if (world.torque_per_k == 0.0) return reported * (1.0 + world.torque_change);
  const VectorXd warm = winding_above_ambient(world, comparison, reported);
  return (reported.array() * (1.0 + world.torque_per_k * warm.array()) * (1.0 + world.torque_change)).matrix();
}

}  // namespace voltlap::plant
