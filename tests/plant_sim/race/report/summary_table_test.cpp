// SPDX-License-Identifier: Apache-2.0
#include "race/report/summary_table.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(SummaryTable) {
  const std::string file = VOLTLAP_SOURCE_DIR "/plant_sim/data/reference/endurance.csv";
  RunDescription run{.vehicle = "vtm16e", .course = "michigan_2015", .lap_start = "standing", .laps = 27};
  EnduranceResult result;

  std::string found() {
    const auto row = find_reference(file, run);
    return row ? row->run : "none";
  }
};

TEST(SummaryTable, NominalRunFindsItsRow) { STRCMP_EQUAL("nominal_2015", found().c_str()); }

TEST(SummaryTable, ChangedParameterFindsItsOwnRowOrNone) {
  run.settings = {"powertrain.final_drive=2.75"};
  STRCMP_EQUAL("final_drive_103pct_2015", found().c_str());
  run.settings = {"powertrain.final_drive=2.8"};
  STRCMP_EQUAL("none", found().c_str());
}

TEST(SummaryTable, OtherLapsStartTrackOrVehicleFindNoRow) {
  const RunDescription nominal = run;
  run.laps = 26;
  STRCMP_EQUAL("none", found().c_str());
  run = nominal;
  run.lap_start = "flying";
  STRCMP_EQUAL("none", found().c_str());
  run = nominal;
  run.course = "michigan_2014";
  STRCMP_EQUAL("none", found().c_str());
  run = nominal;
  run.vehicle = "vtm17e";
  STRCMP_EQUAL("none", found().c_str());
}

TEST(SummaryTable, ErrorsAreInPointsOrPercent) {
  result.finished = true;
  result.end_soc_pct = 28.5;
  result.total_time_s = 2072.4 * 1.01;
  const std::string table = summary_table(run, result, find_reference(file, run));
  STRCMP_CONTAINS("+0.50 points", table.c_str());
  STRCMP_CONTAINS("+1.00 %", table.c_str());
}

TEST(SummaryTable, FailedRunSaysWhenAndWhy) {
  result.failure_time_s = 12.345;
  result.failure_cause = "the pack is empty";
  STRCMP_CONTAINS("FAILED vtm16e on michigan_2015 after 12.35 s, 0 laps done: the pack is empty.",
                  summary_table(run, result, std::nullopt).c_str());
}

TEST(SummaryTable, WhatBrakingGaveBackIsSaidWhereItDid) {
  result.energy_out_kwh = 0.4;
  CHECK(summary_table(run, result, std::nullopt).find("regenerated") == std::string::npos);
  result.energy_back_kwh = 0.02;
  STRCMP_CONTAINS("regenerated: 0.020 kWh, 4.8 % of what was taken: 5.0 % more range",
                  summary_table(run, result, std::nullopt).c_str());
}

TEST(SummaryTable, LimitThatHeldBackIsNamedWithItsTime) {
  result.limit_active_s[1] = 3.25;
  STRCMP_CONTAINS("limits that held back: config_maximum 3.2 s", summary_table(run, result, std::nullopt).c_str());
}
