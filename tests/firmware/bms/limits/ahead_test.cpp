// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/ahead.hpp"

#include "bms/limits/table.hpp"
#include "limits/ahead_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::LimitReason;

TEST_GROUP_BASE(AheadLimit, AheadBench){};

// BMS-045
TEST(AheadLimit, NothingIsAllowedUntilEveryCellHasBeenLookedAt) {
  int ticks = 0;
  for (; discharge_ceiling(config, state).value == Current{}; ++ticks) step(0.0);
  CHECK(ticks > 1);
  for (std::size_t i = 0; i < cells.size(); ++i) CHECK(state.ahead.cell[i].discharge[0] > 0);
  expect_time("BMS-045 all cells", 10 * ticks, 10, 100);
}

// BMS-045
TEST(AheadLimit, TheWeakestCellSetsItAndIsNamed) {
  cells[17].soc = 0.4;
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  const Limit limit = discharge_ceiling(config, state);
  LONGS_EQUAL(17, limit.cell);
  CHECK(limit.reason == LimitReason::kCellVoltage);
  cells[3].soc = 0.99;
  setup();
  state.soc = SocEstimate{};
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  LONGS_EQUAL(3, charge_ceiling(config, state).cell);
}

TEST(AheadLimit, ALongerHorizonIsALowerLimit) {
  for (TrueCell& cell : cells) cell.soc = 0.5;
  for (int tick = 0; tick < 60; ++tick) step(0.0);
  CHECK(discharge(1) < discharge(0) && discharge(2) < discharge(1) && discharge(0) < config.discharge_current_max);
  config.limit_horizon = Duration::from_ms(30'000);
  LONGS_EQUAL(discharge(2).raw(), discharge_ceiling(config, state).value.raw());
}

// BMS-045
TEST(AheadLimit, ALimitThatIsDrawnHoldsTheCellsWhereItSaid) {
  for (TrueCell& cell : cells) cell.soc = 0.6;
  cells[5].resistance = 1.6;  // nobody has told
  double amperes = 0.0, lowest = 5.0;
  for (int tick = 0; tick < 6'000; ++tick) {
    step(amperes);
    const bool pull = tick % 400 < 300;
    amperes = pull ? 1e-3 * state.limits.discharge.value.raw() : 10.0;
    if (tick > 1'000) lowest = std::min(lowest, cells[5].voltage(config));
  }
  CHECK(lowest > 3.37 && lowest < 3.43);
}

// BMS-045
TEST(AheadLimit, TheCellThatLimitsIsLookedAtInEveryStep) {
  cells[9].soc = 0.4;
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  for (int tick = 0; tick < 20; ++tick) {
    state.ahead.cell[9].discharge[0] = 1;  // the least of all: its filter has its turn in one step of ten
    step(50.0);
    CHECK(state.ahead.cell[9].discharge[0] > 50'000);
  }
}

// BMS-045
TEST(AheadLimit, BeforeTheFilterHasStartedNothingIsLookedAt) {
  update_limits(config, Duration::from_ms(10), state);
  LONGS_EQUAL(0, discharge(0).raw());
  LONGS_EQUAL(0, state.limits.discharge.value.raw());
}

// BMS-045
TEST(AheadLimit, OnAChargerItGivesTheChargersCurrentToCellsThatCountAsFull) {
  config.charge_current_max = Current{};
  config.charger_current_max = amps(30);
  for (TrueCell& cell : cells) cell.soc = 1.0;
  config.cell_voltage_max = CellVoltage::from_raw(42'400);
  config.cell_voltage_trip_high = CellVoltage::from_raw(43'000);
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  LONGS_EQUAL(0, charge_ceiling(config, state).value.raw());
  state.contactors.state = can::BmsState::kCharging;
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  LONGS_EQUAL(30'000, charge_ceiling(config, state).value.raw());
}

TEST(AheadLimit, ACellThatResistsMoreIsTakenToHaveWarmedMore) {
  for (int tick = 0; tick < 30; ++tick) step(0.0);
  LONGS_EQUAL(kUnit, state.ahead.scale);
  SocFilter& filter = state.soc.filter;
  filter.heat_began = Temperature::from_raw(200);
  filter.heat_of = Temperature::from_raw(260);             // between the coldest and the hottest
  state.pack.temperature_min = Temperature::from_raw(250);  // 5 K warmer than it began
  filter.cell[7].filter.rho = 2 * kUnit;
  LONGS_EQUAL(-10, own_warmth(state, 0));
  LONGS_EQUAL(100 - 60, own_warmth(state, 7));
  filter.cell[7].filter.rho = 5 * kUnit;
  LONGS_EQUAL(200 - 60, own_warmth(state, 7));  // four times at most
  for (int tick = 0; tick < 30; ++tick) step(0.0);
  CHECK(state.ahead.scale > kUnit + kUnit / 24);  // the mean of all
  state.pack.temperature_min = Temperature::from_raw(190);
  LONGS_EQUAL(0, own_warmth(state, 7));
}

// BMS-045
TEST(AheadLimit, ALimitThatHoldsForEverIsOfTheBranchesAtTheirEnds) {
  config.limit_horizon = Duration::from_ms(0);
  CHECK(config_check(config) == ConfigError::kNone);
  for (TrueCell& cell : cells) cell.soc = 0.5;
  for (int tick = 0; tick < 60; ++tick) step(0.0);
  const Limit limit = discharge_ceiling(config, state);
  LONGS_EQUAL(discharge(3).raw(), limit.value.raw());
  // OCV 3.68 V; 1 mOhm with its slope by current, 0.4 and 0.6 mOhm.
  const double a = 1e-3 * limit.value.raw(), above = std::min(a, 300.0) - 50.0;
  DOUBLES_EQUAL(0.28, a * (1e-3 * (1.0 - 3e-4 * above) + 4e-4 * (1.0 - 1.5e-3 * above) + 6e-4), 0.003);
}

TEST(AheadLimit, BeforeTheMeanOfTheResistancesIsKnownNoCellHasWarmedMore) {
  for (int tick = 0; tick < 30; ++tick) step(0.0);
  state.soc.filter.heat_began = Temperature::from_raw(200);
  state.soc.filter.heat_of = Temperature::from_raw(260);
  CHECK(own_warmth(state, 7) != 0);
  for (const std::int32_t scale : {0, -1}) {
    state.ahead.scale = scale;
    LONGS_EQUAL(0, own_warmth(state, 7));
  }
}

// BMS-045
TEST(AheadLimit, WithoutAFilterOrAMeasurementThereIsNone) {
  for (int tick = 0; tick < 12; ++tick) step(0.0);
  state.soc.valid = false;
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kMeasurementLost);
  LONGS_EQUAL(0, discharge_ceiling(config, state).value.raw());
}

TEST_GROUP(TableLimit) {
  Config config = filtered_config();
  State state{};

  void setup() override {
    config.limit_method = LimitMethod::kTable;
    state.measured.current.quality = Quality::kGood;
    state.pack.cells_good = state.pack.temperatures_good = true;
    state.pack.temperature_min = state.pack.temperature_max = Temperature::from_raw(250);
    state.pack.cell_min = state.pack.cell_max = CellVoltage::from_raw(37'000);
    state.pack.weakest_cell = 4;
    state.soc.valid = true;
    state.soc.value = Soc::from_raw(600'000);
    state.cell_resistance = Resistance::from_raw(2'000);
    state.contactors.state = can::BmsState::kTsActive;
  }
};

// BMS-046
TEST(TableLimit, TemperatureAndChargeTakeTheirShares) {
  const Current all = config.discharge_current_max, in = config.charge_current_max;
  LONGS_EQUAL(all.raw(), discharge_ceiling(config, state).value.raw());
  LONGS_EQUAL(in.raw(), charge_ceiling(config, state).value.raw());
  state.pack.temperature_min = Temperature::from_raw(0);
  LONGS_EQUAL(all.raw() * 4 / 10, discharge_ceiling(config, state).value.raw());
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kTemperature);
  LONGS_EQUAL(in.raw() / 10, charge_ceiling(config, state).value.raw());
  state.pack.temperature_min = Temperature::from_raw(250);
  state.soc.value = Soc::from_raw(100'000);
  DOUBLES_EQUAL(0.55 * all.raw(), discharge_ceiling(config, state).value.raw(), 2.0);
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kSocLow);
  state.soc.value = Soc::from_raw(1'000'000);
  LONGS_EQUAL(0, charge_ceiling(config, state).value.raw());
}

// BMS-046
TEST(TableLimit, ACellBeyondItsBoundTakesTheCapDownInASecondAndItComesBackInTen) {
  const auto ticks = [&](int count) {
    for (int i = 0; i < count; ++i) update_limits(config, Duration::from_ms(10), state);
  };
  ticks(200);
  state.pack.cell_min = config.cell_voltage_min - CellVoltage::from_raw(1);
  ticks(50);
  DOUBLES_EQUAL(0.5 * config.discharge_current_max.raw(), state.limits.discharge.value.raw(), 10.0);
  LONGS_EQUAL(4, state.limits.discharge.cell);
  CHECK(state.limits.discharge.reason == LimitReason::kCellVoltage);
  ticks(50);
  LONGS_EQUAL(0, state.limits.discharge.value.raw());
  state.pack.cell_min = config.cell_voltage_min + CellVoltage::from_raw(499);  // not yet clear
  ticks(100);
  LONGS_EQUAL(0, state.limits.discharge.value.raw());
  state.pack.cell_min = config.cell_voltage_min + CellVoltage::from_raw(500);
  ticks(500);
  DOUBLES_EQUAL(0.5 * config.discharge_current_max.raw(), state.limits.discharge.value.raw(), 10.0);
  state.pack.cell_max = config.cell_voltage_max + CellVoltage::from_raw(1);
  ticks(150);
  LONGS_EQUAL(0, state.limits.charge.value.raw());
  LONGS_EQUAL(0, state.caps.charge.raw());  // not below: it is back in ten seconds
  state.pack.cell_max = config.cell_voltage_max - CellVoltage::from_raw(500);
  state.pack.cells_good = false;  // nothing is known of them
  ticks(100);
  LONGS_EQUAL(0, state.caps.charge.raw());
}

// BMS-046
TEST(TableLimit, OnAChargerThePackIsFilledByTheChargersCurrent) {
  config.charger_current_max = amps(30);
  state.soc.value = Soc::from_raw(990'000);
  CHECK(charge_ceiling(config, state).value < config.charge_current_max);
  state.contactors.state = can::BmsState::kCharging;
  LONGS_EQUAL(30'000, charge_ceiling(config, state).value.raw());
  state.pack.temperature_min = Temperature::from_raw(100);  // half of it
  LONGS_EQUAL(15'000, charge_ceiling(config, state).value.raw());
}

// BMS-046: without an estimate temperature and the cells' voltages are all there is.
TEST(TableLimit, WithoutAStateOfChargeItTakesNoShare) {
  config.soc_method = SocMethod::kNone;
  state.soc.value = Soc{};
  for (const bool valid : {false, true}) {
    state.soc.valid = valid;
    CHECK_EQUAL(!valid, discharge_ceiling(config, state).value == config.discharge_current_max);
  }
  state.soc.value = Soc::from_raw(1'000'000);
  for (const bool valid : {false, true}) {
    state.soc.valid = valid;
    CHECK_EQUAL(!valid, charge_ceiling(config, state).value == config.charge_current_max);
  }
}
