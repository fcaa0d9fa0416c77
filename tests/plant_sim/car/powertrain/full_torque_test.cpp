// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/full_torque.hpp"

#include <algorithm>
#include <cmath>

#include "car/powertrain/torque_curve.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kRpm = M_PI / 30.0;

}  // namespace

TEST_GROUP(FullTorque) { VehicleParameters car = vtm16e(); };

TEST(FullTorque, IsTheSmallerOfCurrentAndCurve) {
  DOUBLES_EQUAL(81.0, FullTorque(car).torque_nm(2000.0 * kRpm), 0.1);  // Table A.4
  car.inverter.current_max_a = 400.0;
  DOUBLES_EQUAL(60.0, FullTorque(car).torque_nm(2000.0 * kRpm), 1e-6);
  car.motor.constant_nm_per_a = 0.12;
  DOUBLES_EQUAL(48.0, FullTorque(car).torque_nm(2000.0 * kRpm), 1e-6);
  DOUBLES_EQUAL(0.0, FullTorque(car).torque_nm(9100.0 * kRpm), 0.0);
}

TEST(FullTorque, ALowerBusVoltageMovesTheCurveToLowerSpeeds) {
  const MotorSection& motor = car.motor;
  car.motor.curve_voltage_v = 100.0;
  const TorqueCurve curve(motor);
  DOUBLES_EQUAL(curve.torque_nm(6000.0 * kRpm, 100.0), curve.torque_nm(3000.0 * kRpm, 50.0), 1e-9);
  CHECK(curve.torque_nm(5000.0 * kRpm, 70.0) < curve.torque_nm(5000.0 * kRpm, 100.0) - 5.0);
  DOUBLES_EQUAL(0.0, curve.torque_nm(100.0, 0.0), 0.0);
  CHECK(curve.torque_nm(8000.0 * kRpm, 200.0) > curve.torque_nm(8000.0 * kRpm, 100.0) + 5.0);
  DOUBLES_EQUAL(0.0, curve.torque_nm(9020.0 * kRpm, 200.0), 0.0);  // the last speed is the motor's
  double before = 1e9;
  for (const double soc : {1.0, 0.6, 0.2}) {
    car.battery.initial_soc = soc;
    const double torque = FullTorque(car).torque_nm(6000.0 * kRpm);
    CHECK(torque < before);
    before = torque;
  }
}

TEST(FullTorque, NoMoreThanTheMastersLimitLeavesThePack) {
  car.battery.cells_in_series = 100;
  car.motor.constant_nm_per_a = 0.6;
  car.motor.efficiency = 0.9;
  car.inverter.efficiency = 0.95;
  car.motor.curve_torque_nm.assign(car.motor.curve_torque_nm.size(), 300.0);
  // The power of the shaft's current by the master's guess of 0.9, and that of the bus when the guess is too good.
  for (const double guess : {0.9, 1.0}) {
    car.master.drive_efficiency = guess;
    const FullTorque full(car);
    double most = 0.0;
    for (double omega = 0.0; omega < 800.0; omega += 5.0) {
      most = std::max(most, full.torque_nm(omega) * omega / 0.9 / 0.95 + car.low_voltage.power_w);
    }
    DOUBLES_EQUAL(std::min(79e3, 79e3 * guess / 0.95 + car.low_voltage.power_w), most, 100.0);
  }
}

TEST(FullTorque, TheCurrentThatFlowsMakesTheTorqueOfTheCurveInBothDirections) {
  car.motor.efficiency = 0.9;
  const TorqueCurve curve(car.motor);
  for (const double omega : {10.0, 300.0, 800.0, -300.0}) {
    for (const double asked : {1000.0, -1000.0}) {
      const double current = curve.current(asked, omega, 90.0);
      const bool driving = asked * omega >= 0.0;
      const double torque = 0.15 * std::abs(current) * (driving ? 0.9 : 1.0 / 0.9);
      DOUBLES_EQUAL(curve.torque_nm(omega, 90.0), torque, 1e-9);
    }
  }
  DOUBLES_EQUAL(20.0, curve.current(20.0, 100.0, 90.0), 0.0);
}
