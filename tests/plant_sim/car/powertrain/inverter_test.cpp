// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/inverter.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Inverter) {
  InverterSection section = lossy_vtm16e().inverter;
  Inverter inverter{section};
};

TEST(Inverter, DrivesNothingBeforeItsFirstCommand) {
  inverter.advance(0.01);
  CHECK(inverter.state(96.0) == InverterState::kCommandTimeout);
  DOUBLES_EQUAL(0.0, inverter.current(96.0), 0.0);
}

TEST(Inverter, FollowsAnEnabledCommandInsideItsRange) {
  inverter.command(123.0, true);
  DOUBLES_EQUAL(123.0, inverter.current(96.0), 0.0);
  inverter.command(900.0, true);
  DOUBLES_EQUAL(550.0, inverter.current(96.0), 0.0);
  inverter.command(-900.0, true);
  DOUBLES_EQUAL(-550.0, inverter.current(96.0), 0.0);
  inverter.command(123.0, false);
  CHECK(inverter.state(96.0) == InverterState::kDisabled);
  DOUBLES_EQUAL(0.0, inverter.current(96.0), 0.0);
}

TEST(Inverter, StopsOneControlPeriodAfterTheTimeoutAtTheLatest) {
  inverter.command(200.0, true);
  for (int ms = 10; ms <= 40; ms += 10) inverter.advance(0.01);
  DOUBLES_EQUAL(200.0, inverter.current(96.0), 0.0);
  for (int ms = 50; ms <= 60; ms += 10) inverter.advance(0.01);
  DOUBLES_EQUAL(0.0, inverter.current(96.0), 0.0);
  CHECK(inverter.state(96.0) == InverterState::kCommandTimeout);
  inverter.command(50.0, true);
  DOUBLES_EQUAL(50.0, inverter.current(96.0), 0.0);
}

TEST(Inverter, IsOffBelowItsLeastDcVoltage) {
  inverter.command(200.0, true);
  CHECK(inverter.state(39.99) == InverterState::kOff);
  DOUBLES_EQUAL(0.0, inverter.current(39.99), 0.0);
  CHECK(inverter.state(40.0) == InverterState::kEnabled);
}

TEST(Inverter, TakesItsLossFromTheSideThatGivesThePower) {
  DOUBLES_EQUAL(20000.0 / 0.95, inverter.dc_power(20000.0), 1e-9);
  DOUBLES_EQUAL(-20000.0 * 0.95, inverter.dc_power(-20000.0), 1e-9);
  for (const double power : {20000.0, -20000.0, 0.0}) {
    DOUBLES_EQUAL(inverter.dc_power(power) - power, inverter.loss(power), 1e-9);
  }
}
