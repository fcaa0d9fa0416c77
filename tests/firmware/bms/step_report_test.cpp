// SPDX-License-Identifier: Apache-2.0
// What a step tells, and what it does only ten times a second.
#include "bms/bms_step.hpp"

#include "bms/charge/charge_config.hpp"
#include "charge/charge_bench.hpp"
#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(StepReport) {
  Bench bench;
};

TEST(StepReport, TellsWhatWasMeasuredAndEstimated) {
  bench.cell_100uv[7] = 38'500;
  bench.temperature_dc[2] = 310;
  bench.temperature_dc[3] = 190;
  bench.idle();
  bench.current(amps(0.7));
  bench.run(50);
  const Output& out = bench.out;
  LONGS_EQUAL(7, out.weakest_cell);
  CHECK(out.soc_valid);
  LONGS_EQUAL((23 * 750'000 + 708'333) / 24, out.soc.raw());
  DOUBLES_EQUAL(700, out.current.raw(), 10);  // a little of it is taken for an offset
  LONGS_EQUAL(23 * 39'000 + 38'500, out.pack_voltage.raw());
  LONGS_EQUAL(190, out.temperature_min.raw());
  LONGS_EQUAL(310, out.temperature_max.raw());
  LONGS_EQUAL(bench.now_ms - 10, out.now.ms());
}

TEST(StepReport, TellsTheCellsInTurn) {
  bench.cell_100uv[5] = 38'000;
  bench.idle();
  bench.invalid_cells.insert(9);
  bench.run(100);
  for (int k = 0; k < 48; ++k) {
    bench.tick();
    const CellReport& cell = bench.out.cell;
    LONGS_EQUAL((bench.state.steps - 1) % 24, cell.cell);
    CHECK_EQUAL(cell.cell != 9, cell.good);
    LONGS_EQUAL(cell.cell == 5 ? 38'000 : 39'000, cell.voltage.raw());
    LONGS_EQUAL(2'000, cell.resistance.raw());
    CHECK_FALSE(cell.balancing);
  }
}

// BMS-002
TEST(StepReport, AConfigurationThatIsNoneIsToldWithItsTimeAndBothReasons) {
  Bench wrong{Config{}};
  wrong.run(50);
  LONGS_EQUAL(40, wrong.out.now.ms());
  CHECK(wrong.out.limits.discharge.reason == can::LimitReason::kFault);
  CHECK(wrong.out.limits.charge.reason == can::LimitReason::kFault);
  CHECK(wrong.out.waits_for == can::WaitsFor::kConfiguration);
}

// BMS-018: the time since power-on counts, whatever the clock says then.
TEST(StepReport, ADcLinkThatIsUpFromPowerOnIsAWeldFiveSecondsLater) {
  for (const std::uint32_t start_ms : {0U, 100'000U}) {
    Bench late;
    late.now_ms = start_ms;
    late.link_follows = false;
    late.inverter.dc_link_voltage_100uv = 900'000;
    const auto welded = [](const Output& o) { return has(o, can::BmsFault::kContactorWelded); };
    LONGS_EQUAL(-1, late.until(welded, 4'980));
    CHECK(late.until(welded, 1'000) >= 0);
  }
}

// The resistance of the cells is renewed in every tenth step, and only by a known temperature and charge.
TEST(StepReport, TheResistanceIsRenewedInEveryTenthStep) {
  bench.idle();
  for (int k = 0; k < 40; ++k) {
    const bool tenth = bench.state.steps % 10 == 0;
    bench.state.cell_resistance = Resistance::from_raw(1'500);
    bench.tick();
    LONGS_EQUAL(tenth ? 2'000 : 1'500, bench.state.cell_resistance.raw());
  }
  for (const bool known : {false, true}) {
    Bench other;
    if (!known) {
      for (std::size_t i = 0; i < 6; ++i) other.invalid_sensors.insert(i);
    }
    other.run(500);
    CHECK(other.out.soc_valid);
    LONGS_EQUAL(known ? 2'000 : 0, other.state.cell_resistance.raw());
  }
  Bench loaded;
  loaded.current(amps(4));  // within an offset, and beyond what counts as rest
  loaded.config.soc_start_current = amps(1);
  loaded.pack.pack_current_ok = false;
  loaded.run(500);
  CHECK(!loaded.out.soc_valid && loaded.state.pack.hottest_sensor != kNoCell);
  LONGS_EQUAL(0, loaded.state.cell_resistance.raw());
}

// BMS-089
TEST(StepReport, TheCountBeginsAnewAfterALookAtRestThatFollowedABleed) {
  bench.idle();
  for (const bool rested : {false, true}) {
    bench.state.look.rested = rested;
    for (auto& cell : bench.state.look.cell) cell = CellVoltage::from_raw(36'000);
    bench.tick();
    LONGS_EQUAL(rested ? 500'000 : 750'000, bench.out.soc.raw());
    CHECK_FALSE(bench.state.look.rested);
  }
}

namespace {

/// The filter's first cell after a second of current, by what the sensors read at both ends.
double filtered(std::int32_t coldest_dc, std::int32_t hottest_dc, const Config& config = filtered_config()) {
  Bench car(config);
  for (auto& t : car.temperature_dc) t = coldest_dc;
  car.temperature_dc[0] = hottest_dc;
  car.idle();
  car.current(amps(40));
  car.run(1'000);
  return car.state.soc.filter.cell[0].filter.v1;
}

}  // namespace

// BMS-080: no thermistor is at every cell.
TEST(StepReport, TheFilterTakesTheTemperatureBetweenTheColdestAndTheHottestSensor) {
  const double between = filtered(150, 250);
  DOUBLES_EQUAL(filtered(200, 200), between, 0.0);
  Config alike = filtered_config();
  straight_warmth({0, 0, 0, 0, 0}, alike);
  DOUBLES_EQUAL(filtered(250, 250, alike), filtered(200, 300), 0.0);  // their reference is 25 degC
  CHECK(filtered(150, 150) != between && filtered(250, 250) != between && filtered(0, 0) != between);
}

// BMS-088: before there is an estimate a cell is reported by its voltage and the current.
TEST(StepReport, WithoutAnEstimateTheOpenVoltageIsTheReading) {
  Bench car(filtered_config());
  car.config.soc_start_current = Current{};
  car.current(Current::from_raw(100));
  car.run(100);
  CHECK_FALSE(car.out.soc_valid);
  LONGS_EQUAL(39'000, car.out.cell.voltage.raw());
  LONGS_EQUAL(39'000, car.out.cell.open_voltage.raw());
  LONGS_EQUAL(0, car.out.cell.resistance.raw());
}

TEST(StepReport, OffTheChargerNothingIsToldOfACharge) {
  bench.idle();
  bench.state.cells_bled = 3;
  const ChargeReport off = bench.tick().charge;
  CHECK(!off.on && off.voltage_max == PackVoltage{} && off.cells_bled == 0);
}

// BMS-050, BMS-052
TEST(StepReport, OnTheChargerTheBoundOfTheVoltageAndEveryBledCellAreTold) {
  ChargeBench charger(charge_config(), 0.5);
  charger.charge();
  Bench& car = charger.bench;
  LONGS_EQUAL(24 * 42'000, charger_voltage_max(car.config).raw());
  LONGS_EQUAL(24 * 42'000, car.out.charge.voltage_max.raw());
  charger.gives_at_most_a = 0.0;
  car.state.charge.phase = can::ChargePhase::kBleeding;
  car.state.charge.entered = car.now();
  car.state.charge.asked = Current{};
  CellLook& look = car.state.look;
  look.known = true;
  for (auto& cell : look.cell) cell = CellVoltage::from_raw(39'000);
  look.lowest = CellVoltage::from_raw(38'000);
  look.highest = CellVoltage::from_raw(39'000);
  car.config.balancing_voltage_min = CellVoltage::from_raw(30'000);
  charger.run(50);
  LONGS_EQUAL(24, car.out.charge.cells_bled);
  LONGS_EQUAL(0xFF'FFFF, car.out.charge.bled[0]);
  LONGS_EQUAL(0, car.out.charge.bled[1]);
  LONGS_EQUAL(1'000, car.out.charge.spread.raw());
  CHECK(car.out.charge.spread_known && car.out.cell.balancing);
  car.state.balancing[24] = true;  // of no cell of the pack
  charger.tick();
  LONGS_EQUAL(0, car.out.charge.bled[1]);
  look.cell[0] = CellVoltage::from_raw(38'000);
  charger.run(50);
  LONGS_EQUAL(0xFF'FFFE, car.out.charge.bled[0]);
}
