// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_result.hpp"

#include <nlohmann/json.hpp>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(RunResult) {
  VehicleParameters car;
  EnduranceResult result;

  nlohmann::json json() {
    const RunDescription run{.vehicle = "car",
                             .course = "course",
                             .lap_start = "flying",
                             .cells = "all",
                             .seed = 18446744073709551615ULL,
                             .laps = 2};
    return nlohmann::json::parse(run_result_json(run, car, {result, {"t", "p", "b", "m"}, 1.5}));
  }
};

TEST(RunResult, FinishedRunHasNoFailure) {
  result.finished = true;
  CHECK(json()["status"] == "finished");
  CHECK(json()["failure"].is_null());
}

TEST(RunResult, FailedRunCarriesTimeAndCause) {
  result.failure_time_s = 12.5;
  result.failure_cause = "battery at 50.1 degC";
  CHECK(json()["status"] == "failed");
  DOUBLES_EQUAL(12.5, json()["failure"]["time_s"].get<double>(), 0.0);
  CHECK(json()["failure"]["cause"] == "battery at 50.1 degC");
}

TEST(RunResult, EveryPromisedFieldIsThere) {
  const nlohmann::json written = json();
  for (const char* key : {"status",
                          "failure",
                          "end_soc_pct",
                          "max_battery_temp_c",
                          "total_time_s",
                          "max_battery_current_a",
                          "min_pack_voltage_v",
                          "min_cell_voltage_v",
                          "min_cell",
                          "max_speed_mps",
                          "distance_m",
                          "laps",
                          "energy_out_kwh",
                          "energy_ledger_error_pct",
                          "frames",
                          "trace_hash",
                          "hash_plant",
                          "hash_bms",
                          "hash_master",
                          "limit_active_s",
                          "wall_s",
                          "seed",
                          "version",
                          "lap_rows",
                          "parameters"}) {
    CHECK_TRUE_TEXT(written.contains(key), key);
  }
}

TEST(RunResult, LapsLimitsAndHashesKeepTheirPlaces) {
  result.lap_rows = {{1, 80.0, 0.14, 97.0, 0.0}};
  result.limit_active_s[2] = 3.5;
  const nlohmann::json written = json();
  DOUBLES_EQUAL(97.0, written["lap_rows"][0]["end_soc_pct"].get<double>(), 0.0);
  DOUBLES_EQUAL(3.5, written["limit_active_s"]["cell_voltage"].get<double>(), 0.0);
  CHECK(written["trace_hash"] == "t" && written["hash_plant"] == "p" && written["hash_bms"] == "b" &&
        written["hash_master"] == "m");
}

TEST(RunResult, LargestSeedIsKeptExactly) { CHECK(json()["seed"].get<std::uint64_t>() == 18446744073709551615ULL); }

TEST(RunResult, ParametersKeepTheirTypes) {
  car.vehicle.mass_kg = 243.5;
  car.motor.curve_speed_rpm = {0.0, 9000.0};
  const nlohmann::json parameters = json()["parameters"];
  DOUBLES_EQUAL(243.5, parameters["vehicle.mass_kg"].get<double>(), 0.0);
  CHECK(parameters["sensors.noise"].is_boolean());
  CHECK(parameters["powertrain.kind"] == "electric");
  LONGS_EQUAL(2, parameters["motor.curve_speed_rpm"].size());
}
