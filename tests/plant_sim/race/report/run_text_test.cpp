// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_text.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(RunText) {
  RunDescription run{.vehicle = "car", .course = "ring", .lap_start = "flying", .cells = "all", .laps = 27};
  VehicleParameters car;
  EnduranceResult result;

  void setup() override {
    result.finished = true;
    result.total_time_s = 2021.5;
    result.end_soc_pct = 25.96;
    result.max_battery_temp_c = 39.81;
    result.min_cell_voltage_v = 3.5152;
    result.min_cell = 7;
    result.laps = 27;
    result.extreme_times.battery_temp_s = 2021.5;
  }
  std::string said() {
    return headline(run, car, result);
  }
};

TEST(RunText, HeadlineOfAFinishedRunHasTimeChargeTemperatureAndCell) {
  STRCMP_EQUAL(
      "car finished 27 laps of ring in 33:42 min with 26.0 % charge left. Its battery reached 39.8 °C, and its "
      "cells, all alike, sagged to 3.515 V.",
      said().c_str());
}

TEST(RunText, CellsThatDifferHaveAWeakestOne) {
  car.battery.cells.resize(7);
  STRCMP_CONTAINS("its weakest cell, no. 7, sagged to 3.515 V.", said().c_str());
  run.cells = "representative";
  STRCMP_CONTAINS("all alike", said().c_str());
}

TEST(RunText, OneLapIsALap) {
  run.laps = 1;
  STRCMP_CONTAINS("finished 1 lap of ring", said().c_str());
}

TEST(RunText, HeadlineOfAFailureSaysWhenWhereAndWhy) {
  result.finished = false;
  result.failure_time_s = 612.3;
  result.failure_cause = "battery at 50.1 degC";
  result.laps = 8;
  STRCMP_CONTAINS(
      "car did not finish 27 laps of ring: after 10:12 min, in lap 9 of 27, battery at 50.1 degC. It stopped "
      "with 26.0 % charge left.",
      said().c_str());
}

TEST(RunText, ACarThatNeverGotReadyHasOnlyACause) {
  result = {};
  result.failure_cause = "no answer";
  STRCMP_EQUAL("car did not finish 27 laps of ring: it did not start: no answer.", said().c_str());
}

TEST(RunText, ACarThatOnlyStoodHasFinishedNoLap) {
  result.laps = 0;
  STRCMP_CONTAINS("car stood for 33:42 min with 26.0 % charge left.", said().c_str());
}

TEST(RunText, ALostNodeIsTold) {
  result.lost_nodes = {{.node = "bms", .time_s = 72.0, .torque_zero_s = {}, .contactors_open_s = {}}};
  STRCMP_CONTAINS("sagged to 3.515 V. Node bms was lost 1:12 min after power-on.", said().c_str());
}

TEST(RunText, ARecordedDriveHasNoLaps) {
  run.lap_start = "drive";
  STRCMP_CONTAINS("car finished the recorded drive ring in 33:42 min", said().c_str());
  result.finished = false;
  result.failure_cause = "cause";
  CHECK(said().find("lap") == std::string::npos);
}

TEST(RunText, LimitsAreNamedWithTheirTime) {
  STRCMP_EQUAL("none", limits_text(result).c_str());
  result.limit_active_s[1] = 3.0;
  result.limit_active_s[12] = 12.34;
  STRCMP_EQUAL("config_maximum 3.0 s, power 12.3 s", limits_text(result).c_str());
}
