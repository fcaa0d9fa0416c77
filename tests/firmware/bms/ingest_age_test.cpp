// SPDX-License-Identifier: Apache-2.0
// How readings grow old, which belong together, and what is no part of the pack.
#include "bms/ingest.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(IngestAge) {
  Bench bench;
  Measured& m = bench.state.measured;
};

// BMS-001
TEST(IngestAge, EverySampleIsStaleAtItsTimeout) {
  bench.idle();
  const auto age_of = [&](std::uint32_t id, const auto& sample) {
    bench.silent = {id};
    std::int32_t ms = 0;
    while (sample.good() && ms < 1'000) {
      bench.tick();
      ms += 10;
    }
    bench.silent.clear();
    bench.run(1'000);
    CHECK(sample.good());
    return ms;
  };
  LONGS_EQUAL(can::PackSensor::kTimeoutMs, age_of(can::PackSensor::kId, m.pack_voltage));
  LONGS_EQUAL(can::InverterStatus::kTimeoutMs, age_of(can::InverterStatus::kId, m.phase_current));
  LONGS_EQUAL(can::InverterStatus::kTimeoutMs, age_of(can::InverterStatus::kId, m.motor_speed));
  DOUBLES_EQUAL(can::CellVoltages::kTimeoutMs, age_of(can::CellVoltages::kBaseId, m.cell[0]), 30.0);
  DOUBLES_EQUAL(can::CellVoltages::kTimeoutMs, age_of(can::CellVoltages::kBaseId + 7, m.cell[23]), 30.0);
  DOUBLES_EQUAL(can::Temperatures::kTimeoutMs, age_of(can::Temperatures::kBaseId, m.temperature[0]), 100.0);
  DOUBLES_EQUAL(can::Temperatures::kTimeoutMs, age_of(can::Temperatures::kBaseId + 1, m.temperature[5]), 100.0);
}

// BMS-001: their positions are in the last frame.
TEST(IngestAge, PositionsBeyondTheLastCellAndSensorAreNoneOfThem) {
  Config config = pack_config();
  config.cells_in_series = 23;
  config.temperature_sensors = 5;
  Bench odd(config);
  odd.tamper = [](Frame& frame) {
    can::CellVoltages cells;
    can::Temperatures temperatures;
    if (can::decode(frame, cells) && cells.group == 7) {
      cells.cell_100uv[2] = 38'000;
      cells.cell_ok[2] = true;
      const std::uint8_t counter = codec::counter_of(frame);
      can::encode(cells, frame);
      codec::seal(frame, counter);
    } else if (can::decode(frame, temperatures) && temperatures.group == 1) {
      temperatures.temperature_dc[2] = 900;
      temperatures.temperature_ok[2] = true;
      const std::uint8_t counter = codec::counter_of(frame);
      can::encode(temperatures, frame);
      codec::seal(frame, counter);
    }
  };
  odd.idle();
  CHECK(odd.state.measured.cell[22].good() && odd.state.measured.temperature[4].good());
  CHECK(odd.state.measured.cell[23].quality == Quality::kNone);
  CHECK(odd.state.measured.temperature[5].quality == Quality::kNone);
  odd.state.measured.cell[23].quality = odd.state.measured.temperature[5].quality = Quality::kGood;
  odd.run(1'000);
  CHECK(odd.state.measured.cell[23].good() && odd.state.measured.temperature[5].good());  // nobody ages them
}

// BMS-022: nothing flows at power-on.
TEST(IngestAge, CellsThatCameBeforeThePacksChannelBelongToWhatItSaysFirst) {
  bench.silent = {can::PackSensor::kId};
  bench.run(500);
  CHECK(m.cell[0].good() && m.cell[23].good());
  for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(0, m.cell_pack[i].raw());
  bench.silent.clear();
  bench.sum_follows_cells = false;
  bench.pack.pack_voltage_100uv = 930'000;
  for (std::uint32_t g = 0; g < 8; ++g) bench.silent.insert(can::CellVoltages::kBaseId + g);
  while (!m.pack_voltage.good()) bench.tick();
  for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(930'000, m.cell_pack[i].raw());
  LONGS_EQUAL(0, m.cell_pack[24].raw());
  bench.pack.pack_voltage_100uv = 920'000;  // what comes next belongs to cells that come with it
  bench.tick();
  LONGS_EQUAL(920'000, m.pack_voltage.value.raw());
  for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(930'000, m.cell_pack[i].raw());
}

// BMS-022
TEST(IngestAge, AfterALossOfThePacksChannelNoCellsReadingIsPairedAnew) {
  bench.idle();
  bench.silent = {can::PackSensor::kId};
  for (std::uint32_t g = 0; g < 8; ++g) bench.silent.insert(can::CellVoltages::kBaseId + g);
  bench.run(100);
  CHECK_FALSE(m.pack_voltage.good());
  bench.silent.erase(can::PackSensor::kId);
  bench.sum_follows_cells = false;
  bench.pack.pack_voltage_100uv = 930'000;
  while (!m.pack_voltage.good()) bench.tick();
  LONGS_EQUAL(24 * 39'000, m.cell_pack[0].raw());
}

// BMS-022
TEST(IngestAge, ACellThatIsNotGoodKeepsTheCurrentAndThePackVoltageOfItsLastReading) {
  bench.idle();
  bench.invalid_cells.insert(4);
  bench.sum_follows_cells = false;
  bench.pack.pack_voltage_100uv = 930'000;
  bench.current(amps(3));
  bench.run(60);
  LONGS_EQUAL(24 * 39'000, m.cell_pack[4].raw());
  LONGS_EQUAL(0, m.cell_current[4].raw());
  LONGS_EQUAL(930'000, m.cell_pack[3].raw());
  CHECK(m.cell_current[3] > Current{});
}

// BMS-068
TEST(IngestAge, ACurrentThatIsMarkedInvalidTeachesNoOffset) {
  bench.pack.pack_current_ok = false;
  bench.run(1'000);
  LONGS_EQUAL(0, bench.state.current_check.readings);
  bench.pack.pack_current_ok = true;
  bench.run(1'000);
  LONGS_EQUAL(16, bench.state.current_check.readings);
}

TEST(IngestAge, TemperaturesHaveArrivedInTheStepOfTheirFramesAlone) {
  bench.idle();
  for (std::uint32_t g = 2; g < can::Temperatures::kGroups; ++g) bench.silent.insert(can::Temperatures::kBaseId + g);
  int arrived = 0;
  for (int tick = 0; tick < 100; ++tick) {
    bench.tick();
    arrived += m.temperatures_arrived ? 1 : 0;
  }
  LONGS_EQUAL(20, arrived);  // two groups of six sensors, every 100 ms
}

// BMS-001: the clock comes round in 49 days.
TEST(IngestAge, ASilenceOfWeeksIsNoFreshness) {
  State state{};
  codec::Sealer sealer;
  Config config = pack_config();
  config.inverter_protocol = InverterProtocol::kAmk;
  const auto step_at = [&](std::uint32_t ms, bool talks) {
    Frame frames[1 + codec::kWheels];
    std::size_t count = 0;
    if (talks) {
      can::PackSensor pack;
      pack.pack_current_ok = pack.pack_voltage_ok = true;
      can::encode(pack, frames[count]);
      sealer.seal(frames[count++]);
      for (std::size_t k = 0; k < codec::kWheels; ++k) {
        codec::AmkActual1 motor;
        motor.actual_velocity_ok = true;
        codec::encode_amk(motor, k, frames[count++]);
      }
    }
    ingest(config, Input{Instant::from_ms(ms), FrameView{frames, count}}, state);
  };
  for (std::uint32_t ms = 1'000; ms <= 1'050; ms += 10) step_at(ms, true);
  CHECK(state.measured.current.good() && state.measured.phase_current.good());
  for (std::uint32_t ms = 1'060; ms <= 2'000; ms += 10) step_at(ms, false);
  CHECK_FALSE(state.measured.current.good() || state.measured.phase_current.good());
  for (const std::uint32_t ms : {0x4000'0000U, 0x8000'0000U, 0xC000'0000U, 0U, 1'050U}) step_at(ms, false);
  CHECK_FALSE(state.measured.current.good() || state.measured.phase_current.good());
  step_at(1'060, true);  // as the next frame of the count, and of a sender that has begun anew
  CHECK_FALSE(state.measured.current.good());
  step_at(1'070, true);
  CHECK(state.measured.current.good());
}
