// SPDX-License-Identifier: Apache-2.0
// The rows that the car was calibrated on: reference study, 2016, Table 8.2.
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

struct Row {
  double end_soc_pct, temperature_c, total_time_s, current_a, voltage_v, speed_mps;
};

void check_row(const Row& row, const EnduranceResult& r) {
  STRCMP_EQUAL("", r.failure_cause.c_str());
  CHECK(r.finished);
  DOUBLES_EQUAL(row.end_soc_pct, r.end_soc_pct, 0.7);
  DOUBLES_EQUAL(row.temperature_c, r.max_battery_temp_c, 1.0);
  DOUBLES_EQUAL(row.total_time_s, r.total_time_s, 0.005 * row.total_time_s);
  DOUBLES_EQUAL(row.current_a, r.max_battery_current_a, 0.04 * row.current_a);
  DOUBLES_EQUAL(row.voltage_v, r.min_pack_voltage_v, 0.015 * row.voltage_v);
  DOUBLES_EQUAL(row.speed_mps, r.max_speed_mps, 0.3);
}

/// What must hold of every finished run.
void check_books(const EnduranceOptions& options, const EnduranceResult& r) {
  CHECK(r.charge_balance_error_pct < 0.01);
  CHECK(r.energy_ledger_error_pct < 0.1);
  CHECK(r.bms_soc_error_pct < 0.5);
  CHECK(r.frames_in_tick_max <= 22);
  LONGS_EQUAL(options.laps, r.laps);
  LONGS_EQUAL(options.laps, r.lap_rows.size());
  double time = 0.0, energy = 0.0;
  for (const LapRow& lap : r.lap_rows) {
    time += lap.time_s;
    energy += lap.energy_kwh;
  }
  DOUBLES_EQUAL(r.total_time_s, time, 0.02);
  DOUBLES_EQUAL(r.energy_out_kwh, energy, 1e-3 * energy);
  DOUBLES_EQUAL(r.end_soc_pct, r.lap_rows.back().end_soc_pct, 0.01);
}

}  // namespace

TEST_GROUP(NominalRows){};

TEST(NominalRows, Michigan2015With27LapsFromRest) {
  const EnduranceOptions options = study_row(2015);
  const EnduranceResult r = drive(options);
  check_row({28.0, 39.0, 2072.4, 224.0, 84.4, 18.8}, r);
  check_books(options, r);
}

TEST(NominalRows, Michigan2014With29LapsFromRest) {
  const EnduranceOptions options = study_row(2014);
  const EnduranceResult r = drive(options);
  check_row({31.6, 40.0, 1875.5, 242.0, 84.6, 20.4}, r);
  check_books(options, r);
}

TEST(NominalRows, FlyingLapsCoverTheirWholeLengthAreAlikeAndFasterThanLapsFromRest) {
  const EnduranceOptions options = nominal(2);
  const EnduranceResult r = drive(options);
  check_books(options, r);
  DOUBLES_EQUAL(2.0 * options.track.length_m(), r.distance_m, 0.3);
  DOUBLES_EQUAL(r.lap_rows[1].time_s, r.lap_rows[0].time_s, 0.1);
  CHECK(r.lap_rows[1].time_s < 2072.4 / 27.0);
}
