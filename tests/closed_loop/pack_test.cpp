// SPDX-License-Identifier: Apache-2.0
// What the pack and its limits mean on the road.
#include <algorithm>
#include <numeric>

#include "fixtures.hpp"
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

double limited_s(const EnduranceResult& r) {
  return std::accumulate(r.limit_active_s.begin(), r.limit_active_s.end(), 0.0);
}

double limited_s(const EnduranceResult& r, const char* reason) {
  for (std::size_t i = 0; i < kLimitReasons; ++i) {
    if (std::string(limit_reason_name(i)) == reason) return r.limit_active_s[i];
  }
  FAIL("no such reason");
  return 0.0;
}

}  // namespace

TEST_GROUP(PackOnTheRoad) {
  EnduranceOptions options = nominal();
};

TEST(PackOnTheRoad, ACellOfEightPercentLessCapacityIsTheOneThatLimits) {
  options.laps = 3;
  options.representative_cell = false;
  options.vehicle.battery.initial_soc = 0.4;
  options.vehicle.battery.cells.resize(7);
  options.vehicle.battery.cells[6].capacity_scale = 0.92;
  const EnduranceResult r = drive(options);
  CHECK(r.finished);
  LONGS_EQUAL(7, r.min_cell);
}

TEST(PackOnTheRoad, EqualCellsAgreeWithTheRepresentativeOne) {
  const EnduranceResult one = drive(options);
  options.representative_cell = false;
  const EnduranceResult all = drive(options);
  DOUBLES_EQUAL(one.end_soc_pct, all.end_soc_pct, 1e-6);
  DOUBLES_EQUAL(one.min_pack_voltage_v, all.min_pack_voltage_v, 1e-6);
  DOUBLES_EQUAL(one.max_battery_temp_c, all.max_battery_temp_c, 1e-6);
  DOUBLES_EQUAL(one.total_time_s, all.total_time_s, 1e-9);
}

TEST(PackOnTheRoad, AFullPackDrivesWithoutAnyLimit) { DOUBLES_EQUAL(0.0, limited_s(drive(options)), 0.0); }

TEST(PackOnTheRoad, ADischargeLimitThatBindsHoldsTheCurrentAndCostsLapTime) {
  const EnduranceResult free = drive(options);
  options.vehicle.bms.discharge_current_max_a = 60.0;
  options.vehicle.assertions.speed_error_max_mps = 100.0;
  Record record;
  const EnduranceResult limited = drive(options, record);
  CHECK(limited.finished);
  CHECK(limited.total_time_s > free.total_time_s + 3.0);
  CHECK(limited_s(limited, "config_maximum") > 5.0);
  double most = 0.0;
  for (const TimeSample& s : record.samples) most = std::max(most, s.pack_current_a);
  CHECK(most < 66.0);
}

TEST(PackOnTheRoad, ANearlyEmptyPackIsLimitedToKeepItsCellsAtTheirLeastVoltage) {
  options.laps = 2;
  options.vehicle.battery.initial_soc = 0.08;
  options.vehicle.cell.voltage_min_v = 3.1;
  options.vehicle.assertions.speed_error_max_mps = 100.0;
  const EnduranceResult r = drive(options);
  CHECK(limited_s(r, "cell_voltage") > 1.0);
  CHECK(r.min_cell_voltage_v > 3.09);
}

TEST(PackOnTheRoad, TheBusKeepsToTwentyTwoFramesATickAt24And48And144Cells) {
  options.representative_cell = false;
  options.drive = RecordedDrive{"start", {0.0, 3.0, 4.0}, {0.0, 6.0, 6.0}, {}, {}};
  options.vehicle.battery.initial_soc = 0.7;
  for (const int cells : {24, 48, 144}) {
    options.vehicle.battery.cells_in_series = cells;
    options.vehicle.sensors.temperature_count = std::min(36, (cells + 3) / 4);
    const EnduranceResult r = drive(options);
    STRCMP_EQUAL("", r.failure_cause.c_str());
    CHECK(r.frames_in_tick_max <= 22);
  }
}

TEST(PackOnTheRoad, NoiseAndQuantisationStopNeitherTheDriveNorTheStateOfCharge) {
  options.vehicle.sensors.noise = options.vehicle.sensors.quantisation = true;
  options.representative_cell = false;
  const EnduranceResult r = drive(options);
  STRCMP_EQUAL("", r.failure_cause.c_str());
  CHECK(r.bms_soc_error_pct < 1.0);
}
