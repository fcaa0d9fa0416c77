// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/motor_map.hpp"

#include <cmath>

#include "car/powertrain/torque_curve.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kRadPerS = M_PI / 30.0;

}  // namespace

TEST_GROUP(MotorMap) {
  MotorSection motor = vtm16e().motor;

  // 100 Nm to 6000 rpm; the losses of a small axial-flux machine.
  void setup() override {
    motor.curve_speed_rpm = {0.0, 6000.0};
    motor.curve_torque_nm = {100.0, 100.0};
    motor.constant_nm_per_a = 0.5;
    motor.winding_loss = true;
    motor.winding_resistance_ohm = 0.08;
    motor.drag_hysteresis_nm = 0.8;
    motor.drag_eddy_nm_s = 0.002;
  }
};

TEST(MotorMap, PeaksWhereTheCopperOfTheTorqueLosesAsMuchAsIsLostWithoutIt) {
  // P / (T w) = 1 + (k0 + k1 T + k2 T^2) / (T w) is least where k2 T^2 = k0, with I = (T + drag) / K.
  const MotorSummary summary = motor_summary(motor);
  DOUBLES_EQUAL(100.0, summary.torque_peak_nm, 1e-9);
  DOUBLES_EQUAL(6000.0, summary.speed_max_rpm, 1e-9);
  DOUBLES_EQUAL(100.0 * 6000.0 * kRadPerS, summary.power_peak_w, 1e-6);
  const double omega = summary.efficiency_peak_rpm * kRadPerS, drag = 0.8 + 0.002 * omega;
  const double k2 = 0.08 / (0.5 * 0.5), k0 = drag * omega + k2 * drag * drag;
  DOUBLES_EQUAL(std::sqrt(k0 / k2), summary.efficiency_peak_nm, 0.6);  // a step of the map
  const double torque = summary.efficiency_peak_nm, current = (torque + drag) / 0.5;
  const double losses = 0.08 * current * current + drag * omega;
  DOUBLES_EQUAL(torque * omega / (torque * omega + losses), summary.efficiency_peak, 1e-12);
}

TEST(MotorMap, HoldsNothingAboveTheTorqueCurve) {
  motor.curve_speed_rpm = {0.0, 3000.0, 6000.0};
  motor.curve_torque_nm = {100.0, 100.0, 40.0};
  motor.curve_voltage_v = 300.0;
  const EfficiencyMap map = efficiency_map(motor, 60, 50);
  const TorqueCurve curve(motor);
  LONGS_EQUAL(60 * 50, map.efficiency.size());
  for (std::size_t t = 0; t < map.torque_nm.size(); ++t) {
    for (std::size_t s = 0; s < map.speed_rpm.size(); ++s) {
      const double most = curve.torque_nm(map.speed_rpm[s] * kRadPerS, 300.0);
      if (std::abs(map.torque_nm[t] - most) > 1e-6) CHECK(std::isnan(map.at(t, s)) == (map.torque_nm[t] > most));
    }
  }
}

TEST(MotorMap, GivesBackAsMuchAsItLosesLess) {
  const MotorPoint driving = motor_point(motor, 50.0, 300.0, 25.0), braking = motor_point(motor, -50.0, 300.0, 25.0);
  CHECK(driving.loss_w > 0.0 && braking.loss_w > 0.0);
  DOUBLES_EQUAL(15000.0 / (15000.0 + driving.loss_w), driving.efficiency, 1e-12);
  DOUBLES_EQUAL((15000.0 - braking.loss_w) / 15000.0, braking.efficiency, 1e-12);
  CHECK(std::abs(driving.current_a) > std::abs(braking.current_a));  // the drag brakes, too
  DOUBLES_EQUAL(0.0, motor_point(motor, -0.5, 300.0, 25.0).efficiency, 0.0);
  DOUBLES_EQUAL(0.0, motor_point(motor, 0.0, 300.0, 25.0).efficiency, 0.0);
}
