// SPDX-License-Identifier: Apache-2.0
#include "bms/ingest.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(Ingest) {
  Bench bench;
  void setup() override { bench.idle(); }
};

TEST(Ingest, EverythingSentArrivesInItsUnit) {
  bench.drive();
  bench.current(amps(12.345));
  bench.cell_100uv[10] = 38'765;
  bench.temperature_dc[4] = 287;
  bench.run(200);
  LONGS_EQUAL(12'345, bench.state.measured.current.value.raw());
  LONGS_EQUAL(38'765, bench.state.measured.cell[10].value.raw());
  LONGS_EQUAL(287, bench.state.measured.temperature[4].value.raw());
  CHECK(bench.state.pack.cells_good && bench.state.pack.temperatures_good);
}

// BMS-001
TEST(Ingest, ReadingOutsideOfThePlausibleRangeIsInvalidAndChangesNothing) {
  const std::int32_t kBad[] = {0, 1, 4'998, 4'999, 50'001, 50'002, 65'000};
  for (std::int32_t v : kBad) {
    bench.cell_100uv[5] = v;
    bench.run(30);
    CHECK(bench.state.measured.cell[5].quality == Quality::kInvalid);
    LONGS_EQUAL(39'000, bench.state.measured.cell[5].value.raw());
  }
  for (std::int32_t v : {5'000, 5'001, 49'999, 50'000}) {
    bench.cell_100uv[5] = v;
    bench.run(30);
    LONGS_EQUAL(v, bench.state.measured.cell[5].value.raw());
  }
}

TEST(Ingest, ErrorCodeOnTheWireBecomesNoValue) {
  bench.pack.pack_current_ok = false;
  bench.tick();
  CHECK(bench.state.measured.current.quality == Quality::kInvalid);
}

TEST(Ingest, SilentMessageIsStaleAtItsTimeout) {
  bench.silent.insert(can::PackSensor::kId);
  const std::int32_t took =
      bench.until([&](const Output&) { return bench.state.measured.current.quality == Quality::kStale; }, 1000);
  // the last frame came one step before the first silent one
  expect_time("BMS-001 silent", took + 10, can::PackSensor::kTimeoutMs, can::PackSensor::kTimeoutMs);
}

TEST(Ingest, DamagedFrameRefreshesNothing) {
  bench.tamper = [](Frame& f) {
    if (f.id == can::PackSensor::kId) f.data[7] ^= 0x01U;
  };
  bench.current(amps(50));
  bench.run(40);
  LONGS_EQUAL(0, bench.state.measured.current.value.raw());
  bench.run(20);
  CHECK(bench.state.measured.current.quality == Quality::kStale);
}

TEST(Ingest, RepeatedFrameRefreshesNothing) {
  Frame stuck{};
  bench.tamper = [&](Frame& f) {
    if (f.id != can::PackSensor::kId) return;
    if (stuck.dlc == 0) stuck = f;
    f = stuck;
  };
  bench.run(70);
  CHECK(bench.state.measured.current.quality == Quality::kStale);
}

TEST(Ingest, FrameOfWrongLengthOrOfNobodyIsIgnored) {
  bench.tamper = [](Frame& f) {
    if (f.id == can::PackSensor::kId) f.dlc = 7;
    if (f.id == can::VehicleIo::kId) f.id = 0x123;
  };
  bench.run(110);
  CHECK(bench.state.measured.current.quality == Quality::kStale);
  CHECK(bench.state.measured.io.quality == Quality::kStale);
}

// BMS-001
TEST(Ingest, FirstFrameBehindAnyNumberOfLostOnesIsTaken) {
  for (std::uint32_t lost = 1; lost < 49; ++lost) {  // then the current trips
    Bench car;
    car.drive();
    car.silent.insert(can::PackSensor::kId);
    car.run(10 * lost);
    car.silent.clear();
    car.current(amps(7));
    car.tick();
    LONGS_EQUAL(7'000, car.state.measured.current.value.raw());
    CHECK(car.state.measured.current.good());
    LONGS_EQUAL(0, car.out.faults);
  }
}

// BMS-004
TEST(Ingest, ContestedMessageIsNamedInTheSameStepAndItsSamplesAgeLikeSilence) {
  bench.again = [](Frame& f) {
    if (f.id != can::PackSensor::kId) return false;
    f.data[0] ^= 0x55U;
    codec::seal(f, static_cast<std::uint8_t>(codec::counter_of(f) + 40));
    return true;
  };
  const std::int32_t named =
      bench.until([](const Output& o) { return has(o, can::BmsFault::kForeignFrames); }, 1000);
  expect_time("BMS-004", named, 0, 80);
  CHECK(bench.state.rx.contested());
  const std::int32_t stale =
      bench.until([&](const Output&) { return bench.state.measured.current.quality == Quality::kStale; }, 1000);
  expect_time("BMS-004 stale", stale, 0, can::PackSensor::kTimeoutMs);
}

TEST(Ingest, CellKeepsTheCurrentOfTheStepInWhichItWasMeasured) {
  bench.drive();
  bench.current(amps(40));
  bench.run(30);
  bench.silent.insert(0x200);
  bench.current(amps(90));
  bench.run(30);
  LONGS_EQUAL(40'000, bench.state.measured.cell_current[0].raw());
  LONGS_EQUAL(90'000, bench.state.measured.cell_current[3].raw());
}

TEST(Ingest, CellsBeyondTheLastOneAreNotExpected) {
  Config config = pack_config();
  config.cells_in_series = 23;  // the last frame carries one position that is invalid
  Bench odd(config);
  odd.idle();
  CHECK(odd.state.pack.cells_good);
  CHECK(odd.out.state == can::BmsState::kIdle);
}

TEST(Ingest, CellsOfABigPackAreJudgedByTheirSlowerCycle) {
  Config config = pack_config();
  config.cells_in_series = 144;
  config.temperature_sensors = 36;
  Bench big(config);
  big.run(5'000);
  std::uint8_t ahead = 0;
  big.tamper = [&](Frame& f) {
    if (f.id == 0x200) codec::seal(f, static_cast<std::uint8_t>(codec::counter_of(f) + ahead));
  };
  // 5 s without a frame are 50 of them, and less than half a round.
  big.silent.insert(0x200);
  big.run(5'000);
  big.silent.clear();
  const std::int32_t good = big.until([&](const Output&) { return big.state.measured.cell[0].good(); }, 200);
  CHECK(good >= 0 && good < 100);  // with its first frame
  LONGS_EQUAL(0, big.state.rx.counts(0x200).foreign);
  big.run(2'000);
  ahead = 1;  // a count that runs one frame ahead of 100 ms, though not of 30 ms
  CHECK(big.until([&](const Output&) { return big.state.rx.counts(0x200).foreign > 0; }, 200) >= 0);
}

TEST(Ingest, HundredAndFortyFourCellsComeInWithinTheirTimeout) {
  Config config = pack_config();
  config.cells_in_series = 144;
  config.temperature_sensors = 36;
  Bench big(config);
  big.idle();
  CHECK(big.state.pack.cells_good);
  big.run(3000);
  LONGS_EQUAL(0, big.out.faults);
}

// The first reading pairs the cells before it with itself; one at the clock's zero is not the first.
TEST(Ingest, APackVoltageThatWasGoodAtTheClocksZeroIsNoFirstOne) {
  Bench late;
  late.now_ms = 0U - 4'000U;
  late.run(4'000);
  LONGS_EQUAL(0, late.now_ms);
  late.tick();  // with the cells of group 0
  late.sum_follows_cells = false;
  late.pack.pack_voltage_100uv = 24 * 39'000 + 1'000;
  late.tick();  // with those of group 1
  LONGS_EQUAL(24 * 39'000, late.state.measured.cell_pack[0].raw());
  LONGS_EQUAL(24 * 39'000 + 1'000, late.state.measured.cell_pack[3].raw());
}

// BMS-001: of four motors what stands for all, as old as the oldest of it, and the DC link of the car's own sensor.
TEST(Ingest, FourAmkInvertersAreTheSumOfTheirCurrentsAndTheFastestOfTheirMotors) {
  State state{};
  Config config = bench.config;
  config.inverter_protocol = InverterProtocol::kAmk;
  codec::Sealer sealer;
  Input input;
  input.now = Instant::from_ms(1'000);
  const auto step_with = [&](std::size_t silent) {
    input.now = input.now + Duration::from_ms(10);
    Frame frames[codec::kWheels + 1];
    std::size_t count = 0;
    for (std::size_t k = 0; k < codec::kWheels; ++k) {
      codec::AmkActual1 m;
      m.actual_velocity_rpm = 4'000 + 100 * static_cast<std::int32_t>(k);
      m.actual_velocity_ok = true;
      m.torque_current = 1'000;
      if (k != silent) codec::encode_amk(m, k, frames[count++]);
    }
    can::DcLinkSensor link;
    link.dc_link_voltage_100uv = 900'000;
    link.dc_link_voltage_ok = true;
    encode(link, frames[count]);
    sealer.seal(frames[count++]);
    input.frames = FrameView{frames, count};
    ingest(config, input, state);
  };
  for (int k = 0; k < 3; ++k) step_with(codec::kWheels);
  LONGS_EQUAL(4 * 6'542, state.measured.phase_current.value.raw());
  LONGS_EQUAL(4'300, state.measured.motor_speed.value.raw());
  LONGS_EQUAL(900'000, state.measured.dc_link_voltage.value.raw());
  CHECK(state.measured.phase_current.good() && state.measured.dc_link_voltage.good());
  for (int k = 0; k < 9; ++k) step_with(1);
  CHECK(state.measured.phase_current.good());
  step_with(1);
  CHECK_FALSE(state.measured.phase_current.good());
  CHECK(state.measured.dc_link_voltage.good());
}
