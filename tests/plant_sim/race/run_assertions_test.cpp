// SPDX-License-Identifier: Apache-2.0
#include "race/run_assertions.hpp"

#include <stdexcept>

#include "ecu_words.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(RunAssertions) {
  EcuWords car;
  AssertionSection bounds = vtm16e().assertions;

  void setup() override { say(can::DriveState::kReadyToDrive); }
  void say(can::DriveState state) {
    can::MasterStatus master;
    master.drive_state = state;
    car.say(master);
  }
  std::string broken(RunAssertions& assertions, const DriveMoment& now) {
    return assertions.broken(car.car, car.ecus, now).value_or("");
  }
};

TEST(RunAssertions, ACarThatFollowsItsTargetBreaksNone) {
  RunAssertions assertions(bounds, true);
  STRCMP_EQUAL("", broken(assertions, {20.0, 20.0, 0.0}).c_str());
}

TEST(RunAssertions, ACarBesideItsCourseFailsWithThePlace) {
  RunAssertions assertions(bounds, true);
  STRCMP_EQUAL("", broken(assertions, {20.0, 20.0, 0.0, 3, 341.0, bounds.off_course_max_m}).c_str());
  STRCMP_CONTAINS("ran off the course, 341 m into lap 3: 1.6 m beside its line",
                  broken(assertions, {20.0, 20.0, 0.0, 3, 341.0, -1.6}).c_str());
}

TEST(RunAssertions, ASpeedErrorCountsTenSecondsAfterTheTargetBeganAnew) {
  RunAssertions assertions(bounds, false);
  const double far = bounds.speed_error_max_mps + 0.1;
  STRCMP_EQUAL("", broken(assertions, {100.0, 10.0, far}).c_str());
  STRCMP_CONTAINS("is beyond assertions.speed_error_max_mps", broken(assertions, {100.0, 10.01, far}).c_str());
}

TEST(RunAssertions, TheMasterMustStayReadyToDrive) {
  RunAssertions assertions(bounds, true);
  say(can::DriveState::kFault);
  STRCMP_CONTAINS("left ready-to-drive (drive state Fault", broken(assertions, {1.0, 1.0, 0.0}).c_str());
}

TEST(RunAssertions, BatteryAndMotorHaveATemperatureOfTheirOwn) {
  bounds.battery_temperature_max_c = car.car.pack().temperature_max_c() - 1.0;
  RunAssertions battery(bounds, true);
  STRCMP_CONTAINS("battery at", broken(battery, {1.0, 1.0, 0.0}).c_str());
  bounds.battery_temperature_max_c = 200.0;
  bounds.motor_temperature_max_c = car.car.motor_thermal().copper_c() - 1.0;
  RunAssertions motor(bounds, true);
  STRCMP_CONTAINS("motor winding at", broken(motor, {1.0, 1.0, 0.0}).c_str());
}

TEST(RunAssertions, StandingStillForThirtySecondsFailsOnARoadOnly) {
  RunAssertions road(bounds, true), clock(bounds, false);
  STRCMP_EQUAL("", broken(road, {30.0, 30.0, 0.0}).c_str());
  STRCMP_CONTAINS("has stood still for 30 s", broken(road, {30.1, 30.1, 0.0}).c_str());
  STRCMP_EQUAL("", broken(clock, {300.0, 300.0, 0.0}).c_str());
}

TEST(RunAssertions, AnEmptyCellEndsTheRunWithItsNumberAndThePlace) {
  VehicleParameters nearly = vtm16e();
  nearly.battery.initial_soc = 0.004;
  nearly.battery.cells.resize(7);
  nearly.battery.cells[6].initial_soc_offset = -0.004;
  const Car empty(nearly, false, 0.001);
  RunAssertions assertions(bounds, true);
  STRCMP_CONTAINS("cell 7 is empty, 123 m into lap 5; the pack holds 0.4 % on average",
                  assertions.broken(empty, car.ecus, {20.0, 20.0, 0.0, 5, 123.4}).value_or("").c_str());
}

TEST(RunAssertions, ACellChargedBeyondItsCapacityIsNamedWithThePlace) {
  VehicleParameters over = vtm16e();
  over.battery.initial_soc = 0.998;
  over.battery.cells.resize(7);
  const auto said = [&](double offset) {
    over.battery.cells[6].initial_soc_offset = offset;
    const Car charged(over, false, 0.001);
    RunAssertions assertions(bounds, true);
    return assertions.broken(charged, car.ecus, {20.0, 20.0, 0.0, 5, 123.4}).value_or("");
  };
  STRCMP_EQUAL("", said(0.0025).c_str());
  STRCMP_CONTAINS("cell 7 is charged to 100.2 %, 123 m into lap 5", said(0.004).c_str());
}

TEST(RunAssertions, ASeamThatLiesInTheFutureIsADefect) {
  RunAssertions assertions(bounds, true);
  CHECK_THROWS(std::logic_error, broken(assertions, {1.0, -0.1, 0.0}));
}
