// SPDX-License-Identifier: Apache-2.0
#include "explain/model/cut_torque.hpp"

#include <cmath>
#include <deque>
#include <limits>

#include "car/powertrain/motor.hpp"
#include "explain/balances/car_balances.hpp"
#include "explain/balances/recorded_motor.hpp"

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Largest value within `reach_s` of each row.
VectorXd largest_near(const VectorXd& time_s, const VectorXd& values, double reach_s) {
  VectorXd out(values.size());
  std::deque<Index> falling;  // rows in reach, each larger than those behind it
  Index next = 0;
  for (Index row = 0; row < values.size(); ++row) {
    for (; next < values.size() && time_s(next) <= time_s(row) + reach_s; ++next) {
      if (!std::isfinite(values(next))) continue;
      while (!falling.empty() && values(falling.back()) <= values(next)) falling.pop_back();
      falling.push_back(next);
    }
    while (!falling.empty() && time_s(falling.front()) < time_s(row) - reach_s) falling.pop_front();
    out(row) = falling.empty() ? 0.0 : values(falling.front());
  }
  return out;
}

}  // namespace

plant::Recording without_cut_torque(const plant::World& model, plant::Recording log) {
  constexpr double kReach_s = 30.0;  // over which the battery's limits hardly change
  constexpr double kSurely = 0.8;    // of the power that the pack gave: no limit cuts what is asked below it
  constexpr double kBelowCurve = 0.98;  // of what is asked: the motor's curve cuts, steeply over the speed
  const VectorXd *turns = log.find("motor_speed"), *current = log.find("current"), *volts = plant::pack_voltage(log);
  const auto pedal = log.signals.find("accelerator");
  if (pedal == log.signals.end() || log.find("motor_torque") != nullptr || turns == nullptr || current == nullptr ||
      volts == nullptr)
    return log;
  const plant::MotorSection& motor = model.car.motor;
  const bool slip_unknown = log.derived.contains("motor_speed");
  const VectorXd given_nm = plant::torque_of_pedal(model, log);
  const VectorXd asked_w = given_nm.cwiseProduct(*turns * plant::kRpm),
                 given_w = largest_near(log.time_s, volts->cwiseProduct(*current), kReach_s);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (Index row = 0; row < log.rows(); ++row) {
    const double asked_nm =
        plant::motor_torque(motor, pedal->second(row) * model.car.inverter.current_max_a, (*turns)(row));
    const bool at_curve = slip_unknown && given_nm(row) < kBelowCurve * asked_nm;
    if (at_curve || asked_w(row) > kSurely * given_w(row)) pedal->second(row) = kUnknown;
  }
  return log;
}

}  // namespace voltlap::explain
