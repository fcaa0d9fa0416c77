// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/cell_look.hpp"

#include "bms/estimate/filter_bench.hpp"
#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(CellLook){};

// BMS-055
TEST(CellLook, ReadingsUnderABleedAreMarkedUntilTheyHaveSettled) {
  ChargeBench charger(charge_config(), 0.97);
  charger.cells[2].soc = 0.985;
  charger.charge();
  CHECK(charger.until([](const Output& o) { return o.charge.cells_bled > 0; }, 3'600'000) >= 0);
  charger.tick();
  for (std::size_t i = 0; i < 24; ++i) CHECK_EQUAL(i == 2, charger.bench.state.measured.bled[i]);
  charger.until([](const Output& o) { return o.charge.cells_bled == 0; }, 200'000);
  std::int32_t ms = 0;
  while (charger.bench.state.measured.some_bled) {
    charger.tick();
    ms += 10;
    CHECK(ms < 2'000);
  }
  expect_time("BMS-055", ms, 490, 510);
}

// BMS-055
TEST(CellLook, WhatABledCellReadsTeachesTheFilterAndTheChecksNothing) {
  Config config = filtered_config();
  config.charger_current_max = amps(20);
  config.charge_current_trip = amps(300);
  const auto table = [&](double soc) {
    double v = 0.0;
    for (std::uint8_t i = 1; i < config.ocv.count; ++i) {
      const double from = 1e-6 * config.ocv.soc[i - 1].raw(), to = 1e-6 * config.ocv.soc[i].raw();
      if (soc < from && i > 1) break;
      const double low = 1e-4 * config.ocv.voltage[i - 1].raw(), high = 1e-4 * config.ocv.voltage[i].raw();
      v = low + (high - low) * (soc - from) / (to - from);
    }
    return v;
  };
  ChargeBench charger(config, 0.97);
  charger.ocv = table;
  charger.shunt_a = 0.0;  // only the reading is wrong, by 0.1 V
  charger.cells[2].soc = 0.985;
  charger.charge();
  CHECK(charger.until([](const Output& o) { return o.charge.cells_bled > 0; }, 3'600'000) >= 0);
  const double before = charger.bench.state.soc.filter.cell[2].filter.s;
  charger.run(110'000);
  CHECK(charger.bench.state.cells_bled > 0);
  DOUBLES_EQUAL(before, charger.bench.state.soc.filter.cell[2].filter.s, 0.002 * (1 << 28));
  CHECK_EQUAL(0, charger.bench.out.faults);
}

namespace {

/// All cells of a pack of 24 come in, good.
State arrived(std::int32_t v_100uv) {
  State state;
  state.measured.arrived = 0xFF;
  for (std::size_t i = 0; i < 24; ++i) {
    state.measured.cell[i] = {CellVoltage::from_raw(v_100uv), Instant{}, Quality::kGood};
  }
  return state;
}

}  // namespace

// BMS-055
TEST(CellLook, ALookTakesNoReadingThatIsLostOrUnderABleedAndWaitsForTheCell) {
  for (const bool lost : {false, true}) {
    const Config config = charge_config();
    State state = arrived(41'000);
    const auto look = [&](int times, std::int32_t v_100uv, bool wrong) {
      bool done = false;
      for (int k = 0; k < times && !done; ++k) {
        state.measured.cell[5].value = CellVoltage::from_raw(v_100uv);
        state.measured.cell[5].quality = wrong && lost ? Quality::kInvalid : Quality::kGood;
        state.measured.bled[5] = wrong && !lost;
        done = take_look(config, state);
      }
      return done;
    };
    CHECK_FALSE(look(16, 41'200, false));
    CHECK_FALSE(look(100, 10'000, true));
    CHECK_FALSE(look(15, 41'200, false));
    CHECK(look(1, 41'200, false));
    LONGS_EQUAL(41'200, state.look.cell[5].raw());
    LONGS_EQUAL(41'000, state.look.lowest.raw());
    LONGS_EQUAL(41'000, state.look.cell[4].raw());  // of 32 of its 132 readings
  }
}

// BMS-055
TEST(CellLook, TheHighestCellIsNotOneThatIsReadUnderABleed) {
  const Config config = charge_config();
  State state = arrived(41'000);
  follow_highest(config, true, state);
  state.measured.cell[5].value = CellVoltage::from_raw(42'000);
  state.measured.bled[5] = true;
  for (int k = 0; k < 100; ++k) follow_highest(config, false, state);
  LONGS_EQUAL(41'000, state.look.highest_now.raw());
  state.measured.bled[5] = false;
  for (int k = 0; k < 100; ++k) follow_highest(config, false, state);
  DOUBLES_EQUAL(42'000.0, state.look.highest_now.raw(), 1.0);
}

TEST(CellLook, ALookIsTheMeanOfEveryCellAndTellsTheSpread) {
  ChargeBench charger(charge_config(), 0.97);
  charger.cells[2].soc = 0.98;
  charger.charge();
  CHECK(charger.until([](const Output& o) { return o.charge.spread_known; }, 3'600'000) >= 0);
  DOUBLES_EQUAL(120.0, charger.bench.out.charge.spread.raw(), 2.0);  // a hundredth of 1.2 V
}

// BMS-055
TEST(CellLook, ASumOfManyBledCellsAccusesNoChannel) {
  ChargeBench charger(charge_config(), 0.975);
  charger.cells[0].soc = 0.965;
  charger.sense_v = 0.3;  // 23 cells of it: 7 % of the pack's voltage, more than a cell
  charger.charge();
  CHECK(charger.until([](const Output& o) { return o.charge.cells_bled == 23; }, 3'600'000) >= 0);
  charger.run(300'000);
  CHECK_EQUAL(0, charger.bench.out.faults);
  CHECK(charger.bench.state.cells_bled > 0 || charger.phase() == can::ChargePhase::kResting);
}
