// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/limits.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::LimitReason;

namespace {

/// A state in which nothing but the cells limits: 24 cells at 3.9 V, 2 mOhm, 25 degC, contactors closed.
State driving(const Config& config) {
  State s;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    s.measured.cell[i] = Sample<CellVoltage>{CellVoltage::from_raw(39'000), Instant{}, Quality::kGood};
  }
  s.measured.current.quality = Quality::kGood;
  s.pack.cells_good = s.pack.temperatures_good = true;
  s.pack.temperature_min = s.pack.temperature_max = Temperature::from_raw(250);
  s.soc.valid = true;
  s.soc.value = Soc::from_raw(800'000);
  s.cell_resistance = Resistance::from_raw(2'000);
  s.contactors.state = can::BmsState::kTsActive;
  return s;
}

void set_cell(State& s, std::size_t i, std::int32_t v_100uv, Current current) {
  s.measured.cell[i].value = CellVoltage::from_raw(v_100uv);
  s.measured.cell_current[i] = current;
}

}  // namespace

TEST_GROUP(CurrentLimit) {
  Config config = pack_config();
  State state = driving(config);
};

// BMS-040
TEST(CurrentLimit, WeakestCellSetsTheDischargeLimitByEquation) {
  set_cell(state, 11, 30'000, amps(100));  // 100 A + 0.5 V / 2 mOhm = 350 A
  const Limit limit = discharge_ceiling(config, state);
  LONGS_EQUAL(350'000, limit.value.raw());
  LONGS_EQUAL(11, limit.cell);
  CHECK(limit.reason == LimitReason::kCellVoltage);
}

TEST(CurrentLimit, CellAtMinimumVoltageWithoutCurrentGivesZeroDischargeLimit) {
  for (std::int32_t lsb : {-3, -2, -1, 0, 1, 2, 3}) {
    set_cell(state, 0, 25'000 + lsb, Current{});
    // 0.1 mV over 2 mOhm is 50 mA
    LONGS_EQUAL(lsb > 0 ? 50 * lsb : 0, discharge_ceiling(config, state).value.raw());
  }
}

TEST(CurrentLimit, DischargeLimitIsRoundedDown) {
  state.cell_resistance = Resistance::from_raw(3'000);
  set_cell(state, 0, 25'001, Current{});  // 0.1 mV / 3 mOhm = 33.3 mA
  LONGS_EQUAL(33, discharge_ceiling(config, state).value.raw());
  set_cell(state, 0, 24'999, amps(1));  // 1 A - 33.3 mA
  LONGS_EQUAL(966, discharge_ceiling(config, state).value.raw());
}

TEST(CurrentLimit, ConfigurationCapsTheDischargeLimit) {
  const Limit limit = discharge_ceiling(config, state);  // the cells would give 700 A
  LONGS_EQUAL(500'000, limit.value.raw());
  CHECK(limit.reason == LimitReason::kConfigMaximum);
}

// BMS-041
TEST(CurrentLimit, FullestCellSetsTheChargeLimitByEquation) {
  set_cell(state, 3, 41'000, amps(-20));  // 0.1 V / 2 mOhm + 20 A = 70 A
  const Limit limit = charge_ceiling(config, state);
  LONGS_EQUAL(70'000, limit.value.raw());
  CHECK(limit.reason == LimitReason::kCellVoltage);
  LONGS_EQUAL(3, limit.cell);
}

TEST(CurrentLimit, CellAtMaximumVoltageWithoutCurrentGivesZeroChargeLimit) {
  for (std::int32_t lsb : {-3, -2, -1, 0, 1, 2, 3}) {
    set_cell(state, 0, 42'000 + lsb, Current{});
    LONGS_EQUAL(lsb < 0 ? -50 * lsb : 0, charge_ceiling(config, state).value.raw());
  }
}

TEST(CurrentLimit, FrozenCellIsNotCharged) {
  state.pack.temperature_min = Temperature::from_raw(0);
  CHECK(charge_ceiling(config, state).value > Current{});
  state.pack.temperature_min = Temperature::from_raw(-1);
  LONGS_EQUAL(0, charge_ceiling(config, state).value.raw());
  CHECK(charge_ceiling(config, state).reason == LimitReason::kTemperature);
  CHECK(discharge_ceiling(config, state).value > Current{});
}

// BMS-042
TEST(CurrentLimit, HeatTakesBothLimitsLinearlyToZero) {
  const struct { std::int32_t temperature_dc, discharge_ma; } kRows[] = {
      {549, 500'000}, {550, 500'000}, {551, 490'000}, {575, 250'000}, {599, 10'000}, {600, 0}, {601, 0}, {700, 0}};
  for (const auto& row : kRows) {
    state.pack.temperature_max = Temperature::from_raw(row.temperature_dc);
    LONGS_EQUAL(row.discharge_ma, discharge_ceiling(config, state).value.raw());
    const std::int32_t charge_ma = charge_ceiling(config, state).value.raw();
    CHECK(charge_ma <= row.discharge_ma * 2 / 5);
  }
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kTemperature);
}

TEST(CurrentLimit, LowStateOfChargeTakesTheDischargeLimitToZeroWhenAsked) {
  state.soc.value = Soc::from_raw(50'000);
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kConfigMaximum);
  config.soc_derating_start = Soc::from_raw(100'000);
  LONGS_EQUAL(250'000, discharge_ceiling(config, state).value.raw());
  CHECK(discharge_ceiling(config, state).reason == LimitReason::kSocLow);
  state.soc.value = Soc::from_raw(100'000);
  LONGS_EQUAL(500'000, discharge_ceiling(config, state).value.raw());
  state.soc.value = Soc{};
  LONGS_EQUAL(0, discharge_ceiling(config, state).value.raw());
}

// BMS-043
TEST(CurrentLimit, FallsAtOnceAndRisesSlowly) {
  const Limit high{amps(400), LimitReason::kConfigMaximum, kNoCell};
  const Limit low{amps(100), LimitReason::kCellVoltage, 5};
  const Duration tick = Duration::from_ms(10);
  LONGS_EQUAL(100'000, follow(config, high, low, tick).value.raw());
  CHECK(follow(config, high, low, tick).reason == LimitReason::kCellVoltage);
  const Limit rising = follow(config, low, high, tick);
  LONGS_EQUAL(105'000, rising.value.raw());  // 500 A/s for 10 ms
  CHECK(rising.reason == LimitReason::kCellVoltage);
  LONGS_EQUAL(100'000, follow(config, low, high, Duration{}).value.raw());
}

TEST(CurrentLimit, RiseOfAFewLsbIsNotSlowed) {
  const Limit before{amps(100), LimitReason::kCellVoltage, 5};
  for (std::int32_t lsb : {-1, 0, 1}) {
    const Limit ceiling{amps(105) + Current::from_raw(lsb), LimitReason::kConfigMaximum, kNoCell};
    LONGS_EQUAL(105'000 + (lsb < 0 ? lsb : 0), follow(config, before, ceiling, Duration::from_ms(10)).value.raw());
  }
}

// BMS-044
TEST(CurrentLimit, IsZeroWithItsReasonWhenBlocked) {
  State fault = state;
  fault.faults.open = true;
  CHECK(discharge_ceiling(config, fault).reason == LimitReason::kFault);
  State lost = state;
  lost.pack.cells_good = false;
  CHECK(discharge_ceiling(config, lost).reason == LimitReason::kMeasurementLost);
  State cold_start = state;
  cold_start.soc.valid = false;
  CHECK(charge_ceiling(config, cold_start).reason == LimitReason::kMeasurementLost);
  State no_current = state;
  no_current.measured.current.quality = Quality::kStale;
  CHECK(charge_ceiling(config, no_current).reason == LimitReason::kMeasurementLost);
  State open = state;
  open.contactors.state = can::BmsState::kIdle;
  CHECK(discharge_ceiling(config, open).reason == LimitReason::kContactorsOpen);
  for (const State& s : {fault, lost, cold_start, no_current, open}) {
    LONGS_EQUAL(0, discharge_ceiling(config, s).value.raw());
    LONGS_EQUAL(0, charge_ceiling(config, s).value.raw());
  }
}

TEST(CurrentLimit, AllZeroStateAllowsNothing) {
  const State zero{};
  LONGS_EQUAL(0, discharge_ceiling(config, zero).value.raw());
  LONGS_EQUAL(0, charge_ceiling(config, zero).value.raw());
}

TEST(CurrentLimit, ExtremeReadingsSaturateInsteadOfWrapping) {
  state.cell_resistance = Resistance::from_raw(1);
  for (std::size_t i = 0; i < config.cells_in_series; ++i) set_cell(state, i, 65'535, amps(1000));
  LONGS_EQUAL(500'000, discharge_ceiling(config, state).value.raw());
  LONGS_EQUAL(0, charge_ceiling(config, state).value.raw());
}

TEST(CurrentLimit, FallsInTheStepThatSeesALowCell) {
  Bench bench;
  bench.drive();
  LONGS_EQUAL(500'000, bench.out.limits.discharge.value.raw());
  bench.cells(26'000);
  const auto fallen = [](const Output& o) { return o.limits.discharge.value <= amps(50); };
  expect_time("BMS-043", bench.until(fallen, 1000), 0, 30);
}

TEST(CurrentLimit, IsZeroInTheStepThatFindsAnInvalidCell) {
  Bench bench;
  bench.drive();
  bench.invalid_cells.insert(8);
  expect_time("BMS-044", bench.until([](const Output& o) { return o.limits.discharge.value == Current{}; }, 1000), 0,
              30);
  CHECK(bench.out.limits.discharge.reason == LimitReason::kMeasurementLost);
}

TEST(CurrentLimit, StepOfCurrentBetweenTwoSamplesOfACellDoesNotRaiseTheLimit) {
  Bench bench;
  bench.drive();
  bench.cells(28'000);  // at rest: 0.3 V / 2 mOhm = 150 A
  bench.run(30);
  bench.current(amps(200));  // the voltages on the bus are still those at rest
  bench.invalid_cells.clear();
  for (int i = 0; i < 3; ++i) {
    bench.silent = {0x200, 0x201, 0x202, 0x203, 0x204, 0x205, 0x206, 0x207};
    bench.tick();
    CHECK(bench.out.limits.discharge.value <= amps(150));
  }
}
