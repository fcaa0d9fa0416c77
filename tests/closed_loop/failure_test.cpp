// SPDX-License-Identifier: Apache-2.0
// A run that fails on the road is a result with a cause and a time.
#include "fixtures.hpp"
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(FailedRun) {
  EnduranceOptions options = nominal();

  void check_fails(const char* cause, double from_s, double to_s) {
    const EnduranceResult r = drive(options);
    CHECK_FALSE(r.finished);
    STRCMP_CONTAINS(cause, r.failure_cause.c_str());
    CHECK(r.failure_time_s >= from_s && r.failure_time_s <= to_s);
    DOUBLES_EQUAL(r.failure_time_s, r.total_time_s, 0.0);
    CHECK(r.energy_out_kwh > 0.0);
    CHECK(r.min_cell >= 1);
  }
};

TEST(FailedRun, ABatteryAboveItsTemperatureIsNamedWithItsBound) {
  options.vehicle.assertions.battery_temperature_max_c = 27.0;
  check_fails("is beyond assertions.battery_temperature_max_c = 27", 1.0, 70.0);
}

TEST(FailedRun, AMotorThatIsTooHotIsNamedWithItsBound) {
  options.vehicle.motor.winding_loss = true;
  options.vehicle.assertions.motor_temperature_max_c = 28.0;
  check_fails("is beyond assertions.motor_temperature_max_c = 28", 0.5, 70.0);
}

TEST(FailedRun, ASpeedFarFromTheTargetFailsAfterTheFirstTenSeconds) {
  options.vehicle.bms.discharge_current_max_a = 100.0;
  options.vehicle.bms.temperature_max_c = 28.5;  // derating cells that are at 27 degC: no lap is planned with that
  options.vehicle.assertions.speed_error_max_mps = 3.0;
  check_fails("is beyond assertions.speed_error_max_mps = 3", 10.0, 60.0);
}

TEST(FailedRun, APedalSensorThatTakesTheTorqueIsNamedWithThePlace) {
  options.vehicle.sensors.apps2.gain = 0.8;
  check_fails("AppsImplausible", 10.0, 200.0);
  STRCMP_CONTAINS(" m into lap 1; drive state ReadyToDrive", drive(options).failure_cause.c_str());
}

TEST(FailedRun, ACarThatDoesNotMoveFailsAsStandingStill) {
  options.vehicle.powertrain.kind = "none";
  options.vehicle.assertions.speed_error_max_mps = 100.0;
  check_fails("stood still for 30 s", 30.0, 300.0);  // it coasts first
}

TEST(FailedRun, AnEmptyCellEndsTheRunWithItsPlace) {
  options.laps = 20;
  options.vehicle.battery.initial_soc = 0.02;
  options.vehicle.assertions.speed_error_max_mps = 100.0;
  check_fails("cell 1 is empty, ", 20.0, 2000.0);
}

TEST(FailedRun, APersonCanStopARun) {
  Record record;
  record.stop_after_samples = 50;
  const EnduranceResult r = drive(options, record);
  CHECK(r.stopped);
  CHECK_FALSE(r.finished);
  STRCMP_EQUAL("interrupted", r.failure_cause.c_str());
  DOUBLES_EQUAL(5.0, r.failure_time_s, 0.2);
}

TEST(FailedRun, NoLapsAreNoRun) {
  options.laps = 0;
  STRCMP_CONTAINS("laps: found 0", input_error([this] { static_cast<void>(drive(options)); }).c_str());
}
