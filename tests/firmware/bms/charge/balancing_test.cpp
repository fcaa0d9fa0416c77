// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/balancing.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;

TEST_GROUP(Balancing) {
  ChargeBench charger{charge_config(), 0.97};
  Bench& bench = charger.bench;

  void setup() override {
    charger.cells[2].soc = 0.985;
    charger.charge();
    CHECK(charger.until([](const Output& o) { return o.charge.cells_bled > 0; }, 3'600'000) >= 0);
  }
  [[nodiscard]] std::int32_t off_after() {
    return charger.until([](const Output& o) { return o.charge.cells_bled == 0; }, 5'000);
  }
};

TEST(Balancing, BleedsTheCellThatStandsAboveTheWeakestOnly) {
  for (std::size_t i = 0; i < 24; ++i) CHECK_EQUAL(i == 2, bench.state.balancing[i]);
  CHECK(bench.out.charge.bled[0] == 4U && bench.out.charge.bled[1] == 0U);
  CHECK(bench.out.charge.asked == Current{});
}

TEST(Balancing, HalfOfTheDifferenceIsTriedOnBothSides) {
  CellLook look;
  look.known = true;
  for (auto& cell : look.cell) cell = CellVoltage::from_raw(41'000);
  look.lowest = look.highest = CellVoltage::from_raw(41'000);
  for (const std::int32_t lsb : {-1, 0, 1, 2}) {
    look.cell[5] = CellVoltage::from_raw(41'015 + lsb);
    CHECK_EQUAL(lsb > 0, some_to_bleed(bench.config, look));
  }
}

TEST(Balancing, CellAtOrBelowItsVoltageFloorIsNotDischarged) {
  CellLook look;
  look.known = true;
  for (auto& cell : look.cell) cell = CellVoltage::from_raw(38'000);
  look.lowest = CellVoltage::from_raw(38'000);
  for (const std::int32_t lsb : {-1, 0, 1}) {
    look.cell[5] = CellVoltage::from_raw(39'000 + lsb);
    CHECK_EQUAL(lsb > 0, some_to_bleed(bench.config, look));
  }
}

// BMS-050
TEST(Balancing, StopsWithTheShutdownCircuitOpen) {
  bench.io.shutdown_closed = false;
  expect_time("BMS-050", off_after(), 0, 100);
  CHECK(bench.out.charge.at_once);
  CHECK_FALSE(charger.bled_with_open_shutdown);
  charger.run(60'000);
  CHECK_EQUAL(0, bench.state.cells_bled);
}

// BMS-050
TEST(Balancing, StopsWithAFaultThoughEveryMeasurementIsGoodAgain) {
  bench.invalid_cells.insert(8);
  expect_time("BMS-050 lost cell", off_after(), 0, 310);  // the age at which a cell is lost
  charger.run(700);
  bench.invalid_cells.clear();
  charger.run(2'000);
  CHECK(bench.state.pack.cells_good && has(bench.out, can::BmsFault::kCellMeasurementLost));
  CHECK_EQUAL(0, bench.state.cells_bled);
}

// BMS-050
TEST(Balancing, StopsUnderLoadAndGoesOnWithoutIt) {
  charger.flows_besides_a = -1.001;
  expect_time("BMS-050 load", off_after(), 0, 100);
  charger.flows_besides_a = 0.0;
  charger.run(200);
  CHECK(bench.state.cells_bled > 0);
}

// BMS-050
TEST(Balancing, WaitsWhileTheCellsAreHot) {
  for (auto& t : bench.temperature_dc) t = 300;
  charger.run(2'000);
  bench.temperature_dc[1] = 550;
  charger.run(200);
  CHECK_EQUAL(0, bench.state.cells_bled);
  CHECK(charger.reason() == can::ChargeReason::kTemperature);
  bench.temperature_dc[1] = 540;
  charger.run(200);
  CHECK(bench.state.cells_bled > 0);
}

TEST(Balancing, StopsWhenTheChargerIsSwitchedOff) {
  bench.io.charge_switch = false;
  CHECK(off_after() <= 10);
}

TEST(Balancing, PausesToMeasure) {
  CHECK(charger.until_phase(ChargePhase::kResting, 121'000) >= 0);
  CHECK_EQUAL(0, bench.state.cells_bled);
  const std::int32_t took = charger.until([](const Output& o) { return o.charge.cells_bled > 0; }, 60'000);
  CHECK(took >= 20'000 && took < 25'000);
}

// BMS-057
TEST(Balancing, ACellAtTheFloorOfTheLastChargeIsNotDischarged) {
  CellLook look;
  look.known = true;
  for (auto& cell : look.cell) cell = CellVoltage::from_raw(40'000);
  look.lowest = CellVoltage::from_raw(40'000);
  look.floor = CellVoltage::from_raw(41'000);
  for (const std::int32_t lsb : {-1, 0, 1}) {
    look.cell[5] = CellVoltage::from_raw(41'000 + lsb);
    CHECK_EQUAL(lsb > 0, some_to_bleed(bench.config, look));
  }
}

TEST(Balancing, WithoutAWholeLookNothingIsBled) {
  CHECK(some_to_bleed(bench.config, bench.state.look));
  bench.state.look.known = false;
  CHECK_FALSE(some_to_bleed(bench.config, bench.state.look));
  request_balancing(bench.config, bench.state);
  CHECK_EQUAL(0, bench.state.cells_bled);
}

// BMS-050
TEST(Balancing, LooksAtFaultsAndMeasurementsItselfWhateverTheChargeSays) {
  const State bleeds = bench.state;
  const auto stops = [&](const auto& change) {
    bench.state = bleeds;
    change(bench.state);
    request_balancing(bench.config, bench.state);
    CHECK_EQUAL(0, bench.state.cells_bled);
    CHECK(bench.state.charge.at_once);
  };
  stops([](State& s) { s.faults.open = true; });
  stops([](State& s) { s.pack.cells_good = false; });
  stops([](State& s) { s.pack.temperatures_good = false; });
  stops([](State& s) { s.measured.current.quality = Quality::kStale; });
  stops([](State& s) { s.measured.io.quality = Quality::kStale; });
  stops([](State& s) { s.contactors.state = can::BmsState::kOpen; });
  bench.state = bleeds;
  request_balancing(bench.config, bench.state);
  CHECK_EQUAL(1, bench.state.cells_bled);
}

// BMS-050
TEST(Balancing, LooksAtTheShutdownCircuitItselfWhateverTheChargeSays) {
  bench.state.measured.io.value.shutdown_closed = false;
  request_balancing(bench.config, bench.state);
  CHECK_EQUAL(0, bench.state.cells_bled);
  bench.state.measured.io.value.shutdown_closed = true;
  request_balancing(bench.config, bench.state);
  CHECK_EQUAL(1, bench.state.cells_bled);
  bench.state.measured.io.value.charge_switch = false;
  request_balancing(bench.config, bench.state);
  CHECK_EQUAL(0, bench.state.cells_bled);
}

TEST_GROUP(BalancingStep) {
  Config config = charge_config();
  State state{};

  void setup() override {
    state = State{};
    VehicleIo io;
    io.charge_switch = io.shutdown_closed = true;
    state.measured.io = {io, Instant{}, Quality::kGood};
    state.measured.current.quality = Quality::kGood;
    state.contactors.state = can::BmsState::kCharging;
    state.charge.phase = ChargePhase::kBleeding;
    state.pack.cells_good = state.pack.temperatures_good = true;
    state.pack.temperature_max = Temperature::from_raw(250);
    state.look.known = true;
    state.look.lowest = CellVoltage::from_raw(41'000);
    for (auto& cell : state.look.cell) cell = CellVoltage::from_raw(41'000);
  }
  std::uint8_t bled() {
    request_balancing(config, state);
    return state.cells_bled;
  }
};

TEST(BalancingStep, EveryCellOfThePackAndNoOther) {
  for (std::size_t i = 0; i <= config.cells_in_series; ++i) {
    setup();
    state.look.cell[i] = CellVoltage::from_raw(41'500);
    CHECK_EQUAL(i < config.cells_in_series, some_to_bleed(config, state.look));
    LONGS_EQUAL(i < config.cells_in_series ? 1 : 0, bled());
    CHECK_EQUAL(i < config.cells_in_series, state.balancing[i]);
  }
}

// BMS-050
TEST(BalancingStep, ACurrentAtItsBoundRestsInEitherDirectionAndOneBeyondDoesNot) {
  state.look.cell[0] = CellVoltage::from_raw(41'500);
  for (const std::int32_t sign : {1, -1}) {
    state.measured.current.value = Current::from_raw(sign * config.balancing_current_max.raw());
    LONGS_EQUAL(1, bled());
    state.measured.current.value = Current::from_raw(sign * (config.balancing_current_max.raw() + 1));
    LONGS_EQUAL(0, bled());
  }
}

// BMS-050: what was stopped is sent at once, what goes on or was never begun is not.
TEST(BalancingStep, OnlyAStopIsSentAtOnce) {
  state.charge.phase = ChargePhase::kNone;
  LONGS_EQUAL(0, bled());
  CHECK_FALSE(state.charge.at_once);
  state.charge.phase = ChargePhase::kBleeding;
  state.look.cell[0] = CellVoltage::from_raw(41'500);
  LONGS_EQUAL(1, bled());
  CHECK_FALSE(state.charge.at_once);
  state.measured.io.value.shutdown_closed = false;
  LONGS_EQUAL(0, bled());
  CHECK(state.charge.at_once);
}
