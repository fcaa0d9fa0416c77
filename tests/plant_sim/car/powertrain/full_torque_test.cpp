// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/full_torque.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

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
  const FullTorque full(car);
  double most = 0.0;
  for (double omega = 0.0; omega < 800.0; omega += 5.0) {
    most = std::max(most, full.torque_nm(omega) * omega / 0.9 / 0.95 + car.low_voltage.power_w);
  }
  DOUBLES_EQUAL(79e3, most, 100.0);
}

TEST(FullTorque, FallsWithSpeedAndRisesWithEverythingThatFeedsItWhateverThePack) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
  std::mt19937 draw(seed);
  const auto uniform = [&draw](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
  for (int k = 0; k < 200; ++k) {
    car = vtm16e();
    car.battery.cells_in_series = static_cast<int>(uniform(10.0, 144.0));
    car.battery.contact_resistance_ohm = uniform(0.0, 1.0);
    car.battery.initial_soc = uniform(0.05, 1.0);
    car.motor.constant_nm_per_a = uniform(0.05, 1.5);
    car.motor.curve_voltage_v = uniform(50.0, 600.0);
    car.motor.winding_loss = uniform(0.0, 1.0) < 0.5;
    car.inverter.current_max_a = uniform(50.0, 800.0);
    car.bms.discharge_current_max_a = uniform(5.0, 600.0);
    const FullTorque full(car);
    VehicleParameters more = car;
    more.battery.contact_resistance_ohm *= 0.5;
    more.bms.discharge_current_max_a *= 1.2;
    more.inverter.current_max_a *= 1.1;
    const FullTorque fed(more);
    const std::string drawn = StringFromFormat("VOLTLAP_TEST_SEED=%u, draw %d", seed, k).asCharString();
    double before = 1e9;
    for (double rpm = 0.0; rpm < 9000.0; rpm += 15.0) {
      const double torque = full.torque_nm(rpm * kRpm);
      CHECK_TEXT(torque <= before + 1e-9, drawn.c_str());
      CHECK_TEXT(torque <= fed.torque_nm(rpm * kRpm) + 1e-9, drawn.c_str());
      before = torque;
    }
  }
}

TEST(FullTorque, TheBmsCurrentAndItsLowestCellVoltageBoundIt) {
  const double before = FullTorque(car).torque_nm(4000.0 * kRpm);
  car.bms.discharge_current_max_a = 100.0;
  const double limited = FullTorque(car).torque_nm(4000.0 * kRpm);
  CHECK(limited < 0.6 * before);
  // 100 A at the bus, less what the low-voltage system takes, is the shaft's power.
  CHECK(std::abs(limited * 4000.0 * kRpm + car.low_voltage.power_w - 100.0 * 24 * 4.0) < 600.0);
  car = vtm16e();
  car.bms.cell_voltage_min_v = 4.12;
  CHECK(FullTorque(car).torque_nm(4000.0 * kRpm) < limited);
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
