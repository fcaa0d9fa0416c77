// SPDX-License-Identifier: Apache-2.0
// Faults that are to be told though something else is missing, and of packs and relays that are not the bench's.
#include "bms/faults.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;

namespace {

std::function<bool(const Output&)> tells(BmsFault fault) {
  return [=](const Output& o) { return has(o, fault); };
}

}  // namespace

TEST_GROUP(FaultBeside) {
  Bench bench;
};

// BMS-010, BMS-011, BMS-012: what is seen to be wrong is wrong.
TEST(FaultBeside, ACellOrASensorBeyondItsBoundTripsInItsTimeThoughAnotherIsMissing) {
  for (const BmsFault fault : {BmsFault::kCellVoltageLow, BmsFault::kCellVoltageHigh, BmsFault::kTemperatureHigh}) {
    Bench car;
    car.config.measurement_lost_time = Duration::from_ms(2'000);
    car.drive();
    const bool heat = fault == BmsFault::kTemperatureHigh;
    if (heat) car.invalid_sensors.insert(0);
    if (!heat) car.invalid_cells.insert(3);
    car.run(200);
    CHECK(car.out.faults == 0 && !(heat ? car.state.pack.temperatures_good : car.state.pack.cells_good));
    if (heat) car.temperature_dc[5] = 600;
    if (!heat) car.cell_100uv[7] = fault == BmsFault::kCellVoltageLow ? 23'999 : 42'501;
    car.tick();
    const std::int32_t took = car.until(tells(fault), 3'000);
    expect_time("BMS-010 to BMS-012 beside a missing one", took, heat ? 990 : 490, heat ? 1'110 : 540);
    CHECK(all_open(car.run(20)));
  }
}

// BMS-026
TEST(FaultBeside, APackVoltageThatNeverCameIsToldHalfASecondAfterPowerOn) {
  bench.pack.pack_voltage_ok = false;
  bench.tick();
  expect_time("BMS-026 from power-on", 10 + bench.until(tells(BmsFault::kVoltageImplausible), 3'000), 500, 510);
}

// BMS-015, BMS-026: a node that starts late in the life of the clock has not waited since its zero.
TEST(FaultBeside, WhatWasNeverGoodIsTimedFromTheStartWhateverTheClockSays) {
  for (const std::uint32_t start_ms : {0U, 1'000'000U, 0x8000'0000U, 0xF000'0000U}) {
    for (const BmsFault fault : {BmsFault::kCurrentMeasurementLost, BmsFault::kVoltageImplausible}) {
      for (const bool silent : {false, true}) {
        Bench late;
        late.now_ms = start_ms;
        const bool current = fault == BmsFault::kCurrentMeasurementLost;
        if (silent && !current) continue;  // the current's fault alone is told then
        if (silent) late.silent.insert(can::PackSensor::kId);
        (current ? late.pack.pack_current_ok : late.pack.pack_voltage_ok) = false;
        late.tick();
        expect_time("BMS-015, BMS-026 never good", 10 + late.until(tells(fault), 3'000), 500, 510);
      }
    }
  }
}

// BMS-015, BMS-026
TEST(FaultBeside, WhatWasLastGoodAtTheClocksZeroIsLostHalfASecondLaterToo) {
  for (const bool current : {false, true}) {
    Bench late;
    late.now_ms = 0U - 10'000U;
    late.drive();
    late.run(0U - late.now_ms);
    late.tick();  // at zero
    CHECK(late.out.faults == 0 && late.now_ms == 10);
    (current ? late.pack.pack_current_ok : late.pack.pack_voltage_ok) = false;
    const BmsFault fault = current ? BmsFault::kCurrentMeasurementLost : BmsFault::kVoltageImplausible;
    expect_time("BMS-015, BMS-026 at zero", 10 + late.until(tells(fault), 3'000), 500, 510);
  }
}

// BMS-019
TEST(FaultBeside, APrechargeRelayThatDoesNotCloseTripsAfterItsTime) {
  bench.idle();
  bench.link_follows = false;
  bench.request(true);
  bench.aux_follow_command = false;
  bench.tick();
  bench.io.air_minus_aux = true;
  expect_time("BMS-019 precharge", 10 + bench.until(tells(BmsFault::kContactorStuckOpen), 3'000), 200, 210);
  CHECK(all_open(bench.out));
}

// BMS-018: a pack below 60 V, whose DC link stays up.
TEST(FaultBeside, ADcLinkAboveHalfOfASmallPackFiveSecondsAfterOpeningTrips) {
  Config small = pack_config();
  small.cells_in_series = 12;
  for (const std::int32_t percent : {49, 51}) {
    Bench car(small);
    car.drive();
    car.request(false);
    car.run(50);
    car.link_follows = false;
    car.inverter.dc_link_voltage_100uv = 12 * 39'000 / 100 * percent;
    const std::int32_t took = car.until(tells(BmsFault::kContactorWelded), 8'000);
    if (percent < 50) LONGS_EQUAL(-1, took);
    if (percent > 50) expect_time("BMS-018 small pack, after opening", took + 50, 5'000, 5'010);
  }
}
