// SPDX-License-Identifier: Apache-2.0
#include "explain/shapes/car_shapes.hpp"

#include <fmt/format.h>

#include "explain/balances/car_balances.hpp"
#include "explain/balances/laps.hpp"

namespace voltlap::plant {
namespace {

using Eigen::ArrayXd;
using Eigen::VectorXd;

/// Signals of the car in numbers around 1, with the rows' time in units of ten minutes.
struct CarSignals {
  VectorXd torque, motor, speed, brake, late;
  explicit CarSignals(const Recording& log) : late((log.time_s.array() - log.time_s(0)).matrix() / 600.0) {
    const auto part = [&](const char* role, double full) {
      const VectorXd* found = log.find(role);
      return found != nullptr ? VectorXd(*found / full) : VectorXd(VectorXd::Zero(log.rows()));
    };
    torque = part("motor_torque", 100.0);
    if (log.find("motor_torque") == nullptr) torque = part("accelerator", 0.7);
    motor = part("motor_speed", 3000.0);
    speed = part("speed", 15.0);
    brake = part("brake", 0.3);
    for (double& pedal : brake) pedal = pedal > 0.03 ? pedal : 0.0;  // below it the pads do not touch
  }
};

/// In a second, over the rows beside it.
VectorXd change_of(const VectorXd& time, const VectorXd& values) {
  return 5.0 * (shifted(time, values, 0.1) - shifted(time, values, -0.1));
}

/// Losses in kilowatts, and the pedal as another measure of the torque.
void power_shapes(const Shown& shown, const CarSignals& s, Shapes& shapes) {
  constexpr double kLevel = 0.1, kDriven = 0.2, kPedal = 0.5,
                   kWarm = 1.0;  // a winding begins no two drives equally warm
  const Recording& log = shown.comparison.log;
  const auto add = [&](double usual, const char* what, const VectorXd& values) {
    shapes.add(usual, what, power_as_torque(log, 1000.0 * values));
  };
  const VectorXd square = s.torque.cwiseAbs2();
  add(kLevel, "1", VectorXd::Ones(s.late.size()));
  add(kDriven, "torque^2", square);
  add(kWarm, "torque^2 warm", times(square, shapes.behind(square, 300.0)));
  add(kDriven, "motor speed", s.motor);
  add(kDriven, "motor speed^2", s.motor.cwiseAbs2());
  add(kDriven, "torque motor speed", times(s.torque, s.motor));
  add(kDriven, "|torque| motor speed", times(s.torque.cwiseAbs(), s.motor));
  const VectorXd *pedal = log.find("accelerator"), *torque = log.find("motor_torque");
  if (pedal == nullptr || torque == nullptr) return;
  const double full = shown.model.car.inverter.current_max_a * shown.model.car.motor.constant_nm_per_a;
  const VectorXd apart = *pedal * full - torque->cwiseMax(0.0);
  shapes.add(kPedal, "pedal beyond torque", power_as_torque(log, times(apart, s.motor) * 314.0));
}

/// The road rises and falls alike in every lap. Where a stint begins in the lap is not known.
void road_shapes(const Recording& log, double usual, Shapes& shapes) {
  constexpr std::size_t kStints = 2;
  constexpr int kWaves = 4;  // in a lap
  constexpr double kTurn = 2.0 * 3.14159265358979323846;
  const std::vector<Stint> stints = stints_of(log, kStints);
  const double lap = lap_length(log, stints);
  for (std::size_t k = 0; lap > 0.0 && k < stints.size(); ++k) {
    const ArrayXd angle = stints[k].position_m.array() * (kTurn / lap);
    for (int wave = 1; wave <= kWaves; ++wave) {
      VectorXd rise = VectorXd::Zero(log.rows()), fall = rise;
      rise.segment(stints[k].first, angle.size()) = (angle * wave).sin().matrix();
      fall.segment(stints[k].first, angle.size()) = (angle * wave).cos().matrix();
      shapes.add(usual, fmt::format("road {} sine {}", k, wave), gain_of_speed(log, rise));
      shapes.add(usual, fmt::format("road {} cosine {}", k, wave), gain_of_speed(log, fall));
    }
  }
}

/// Forces that act on a car, each as the gain of speed that it makes.
void force_shapes(const Recording& log, const CarSignals& s, Shapes& shapes) {
  constexpr double kLevel = 0.5, kDriven = 0.5, kTiming = 0.5, kRoad = 0.02;
  const auto add = [&](double usual, const char* what, const VectorXd& values) {
    shapes.add(usual, what, gain_of_speed(log, values));
  };
  add(kLevel, "1", VectorXd::Ones(s.late.size()));
  add(kLevel, "time", s.late);
  add(kLevel, "speed^2", s.speed.cwiseAbs2());
  add(kDriven, "torque", s.torque);
  add(kDriven, "torque^2", s.torque.cwiseAbs2());
  add(kDriven, "torque time", times(s.torque, s.late));
  add(kDriven, "brake", s.brake);
  add(kDriven, "brake^2", s.brake.cwiseAbs2());
  add(kDriven, "brake time", times(s.brake, s.late));
  road_shapes(log, kRoad, shapes);
  // Rows are moments, what lies between them is taken as straight.
  add(kTiming, "change of torque", change_of(shapes.time(), s.torque));
  add(kTiming, "change of brake", change_of(shapes.time(), s.brake));
}

void slip_shapes(const CarSignals& s, Shapes& shapes) {
  constexpr double kRadius = 0.5, kSlip = 0.5;
  VectorXd slip = s.speed;
  shapes.add(kRadius, "speed", slip);
  shapes.add(kRadius, "speed time", times(slip, s.late));
  shapes.add(kRadius, "speed^2", times(slip, s.speed));
  for (int power = 1; power <= 3; ++power) {
    slip = times(slip, s.torque);
    shapes.add(kSlip, fmt::format("speed torque^{}", power), slip);
  }
}

}  // namespace

void car_shapes(const Shown& shown, const BalanceChannel& channel, Shapes& shapes) {
  const CarSignals signals(shown.comparison.log);
  if (channel.name == "power") {
    power_shapes(shown, signals, shapes);
  } else if (channel.name == "speed") {
    force_shapes(shown.comparison.log, signals, shapes);
  } else if (channel.name == "motor_speed") {
    slip_shapes(signals, shapes);
  } else {
    constexpr double kTorque = 0.5;
    shapes.add(kTorque, "1", VectorXd::Ones(signals.late.size()));
    shapes.add(kTorque, "speed", signals.speed);
  }
}

}  // namespace voltlap::plant
