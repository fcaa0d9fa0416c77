// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/horizon.hpp"

#include <random>

#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr std::int32_t kMost = 400'000;
constexpr HorizonBound kLow{Direction::kDischarge, CellVoltage::from_raw(34'000), kMost};
constexpr HorizonBound kHigh{Direction::kCharge, CellVoltage::from_raw(42'000), kMost};

std::int32_t raw(double x) { return static_cast<std::int32_t>(std::lround(std::ldexp(x, kUnitBits))); }

}  // namespace

TEST_GROUP(Horizon) {
  Config config = filtered_config();
  SocFilter filter{};
  std::mt19937_64 random{5};

  void setup() override {
    make_model(config, filter.model);
    // 10 Ah: as soc_ekf does
    filter.charge_bits = 36;
    filter.per_charge = static_cast<std::int32_t>(std::lround(std::ldexp(1.0, 28 + 36) / (10'000.0 * 7.2e6)));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  std::int32_t limit(const CellFilter& cell, const HorizonBound& bound, std::int32_t ms, std::int32_t from = 0) const {
    const Horizon horizon = make_horizon(config, filter, Duration::from_ms(ms), heat_change(filter));
    return current_until({filter, cell, horizon, prudent_fade(cell)}, bound, from);
  }
  static CellFilter rested(double soc) {
    CellFilter cell;
    cell.s = raw(soc);
    return cell;
  }
  CellFilter drawn() {
    CellFilter cell = rested(uniform(0.0, 1.0));
    cell.v1 = raw(4.0 * uniform(-0.05, 0.1));
    cell.v2 = raw(4.0 * uniform(-0.05, 0.1));
    cell.rho = raw(uniform(0.5, 3.0));
    cell.fade = raw(uniform(-0.2, 0.3));
    return cell;
  }
  /// Of the cell by itself, in steps of 10 ms.
  double true_end(double soc, double amperes, double seconds) const {
    TrueCell cell;
    cell.soc = soc;
    for (double t = 0.0; t < seconds - 0.005; t += 0.01) cell.advance(amperes, 0.01);
    return cell.voltage(config);
  }
};

// BMS-045
TEST(Horizon, ACellEndsAtItsBoundWhenTheLimitHasFlowedForItsTime) {
  for (const double soc : {0.2, 0.35, 0.5}) {
    for (const std::int32_t ms : {1'000, 10'000, 30'000}) {
      const std::int32_t ma = limit(rested(soc), kLow, ms);
      CHECK(ma > 10'000 && ma < kMost);
      DOUBLES_EQUAL(3.4, true_end(soc, 1e-3 * ma, 1e-3 * ms), 0.025);
    }
  }
  const std::int32_t ma = limit(rested(0.97), kHigh, 10'000);
  CHECK(ma > 20'000 && ma < kMost);
  DOUBLES_EQUAL(4.2, true_end(0.97, -1e-3 * ma, 10.0), 0.005);
}

TEST(Horizon, WhateverItWasTheLastTimeItComesToTheSame) {
  for (int draw = 0; draw < 2'000; ++draw) {
    const CellFilter cell = drawn();
    const std::int32_t ms = draw % 4 == 0 ? 0 : 1'000 * (1 + draw % 30);
    for (const HorizonBound& bound : {kLow, kHigh}) {
      const std::int32_t from_zero = limit(cell, bound, ms), from_most = limit(cell, bound, ms, kMost);
      const std::int32_t from_any = limit(cell, bound, ms, static_cast<std::int32_t>(uniform(0.0, kMost)));
      const double close = 100.0 + 0.005 * from_zero;
      DOUBLES_EQUAL(from_zero, from_most, close);
      DOUBLES_EQUAL(from_zero, from_any, close);
    }
  }
}

TEST(Horizon, LessChargeMoreResistanceAndMoreTimeNeverAllowMore) {
  for (int draw = 0; draw < 2'000; ++draw) {
    CellFilter cell = rested(uniform(0.02, 1.0));
    cell.rho = raw(uniform(0.5, 3.0));
    const std::int32_t ms = 1'000 * (1 + draw % 29), now = limit(cell, kLow, ms);
    const double slack = 100.0 + 0.006 * now;
    CellFilter emptier = cell, worse = cell;
    emptier.s -= raw(0.02);
    worse.rho += raw(0.2);
    CHECK(limit(emptier, kLow, ms) <= now + slack);
    CHECK(limit(worse, kLow, ms) <= now + slack);
    CHECK(limit(cell, kLow, ms + 1'000) <= now + slack);
  }
}

TEST(Horizon, NothingIsAllowedToACellBeyondItsBoundAndAllToOneThatCanDoIt) {
  LONGS_EQUAL(0, limit(rested(0.0), kLow, 1'000, kMost));
  LONGS_EQUAL(0, limit(rested(-0.03), kLow, 30'000, kMost));
  LONGS_EQUAL(0, limit(rested(1.03), kHigh, 1'000, kMost));
  CellFilter sagged = rested(0.3);
  sagged.v1 = raw(4.0 * 0.3);
  LONGS_EQUAL(0, limit(sagged, kLow, 1'000));
  LONGS_EQUAL(kMost, limit(rested(0.9), kLow, 1'000, 7));
  LONGS_EQUAL(kMost, limit(rested(0.2), kHigh, 1'000, 7));
}

TEST(Horizon, NoMoreIsDrawnThanThereIs) {
  CellFilter cell = rested(0.02);
  cell.rho = raw(0.2);
  const HorizonBound deep{Direction::kDischarge, CellVoltage::from_raw(10'000), kMost};
  // 2 % of 10 Ah in 30 s are 24 A, 20 A for a cell that is empty a fifth sooner.
  DOUBLES_EQUAL(24'000.0, limit(cell, deep, 30'000), 50.0);
  cell.fade = raw(0.2);
  DOUBLES_EQUAL(20'000.0, limit(cell, deep, 30'000), 50.0);
  cell.p.ff = 42'949'673;  // and nobody knows it better than by a tenth
  DOUBLES_EQUAL(24'000.0 / 1.3, limit(cell, deep, 30'000), 50.0);
}

TEST(Horizon, OnAChargerTheVoltageAloneSaysWhatFullIs) {
  CellFilter cell = rested(1.01);  // by a count that is off
  const HorizonBound road{Direction::kCharge, CellVoltage::from_raw(43'000), kMost};
  LONGS_EQUAL(0, limit(cell, road, 1'000));
  const HorizonBound charger{Direction::kCharge, CellVoltage::from_raw(43'000), kMost, false};
  CHECK(limit(cell, charger, 1'000) > 10'000);
}

TEST(Horizon, WhatTheReadingsMissOfTheModelIsCounted) {
  CellFilter cell = rested(0.4);
  const std::int32_t now = limit(cell, kLow, 1'000);
  cell.miss = raw(4.0 * -0.02);  // 20 mV over some 0.95 mOhm
  DOUBLES_EQUAL(now - 21'000, limit(cell, kLow, 1'000), 2'000);
}

TEST(Horizon, ACellThatWarmsItselfMayGiveMoreUpToWhereTheLawEnds) {
  const CellFilter cell = rested(0.4);
  const std::int32_t cold = limit(cell, kLow, 30'000);
  config.heat_capacity_j_per_k = 60;
  filter.heat_known = true;
  filter.heat_of = Temperature::from_raw(250);
  const std::int32_t warming = limit(cell, kLow, 30'000);  // some 30 W: more than 15 K
  CHECK(warming > cold + cold / 50);
  config.heat_capacity_j_per_k = 20;
  const std::int32_t beyond = limit(cell, kLow, 30'000);  // the law ends 25 K above
  CHECK(beyond > warming);
  config.heat_capacity_j_per_k = 10;
  DOUBLES_EQUAL(beyond, limit(cell, kLow, 30'000), 0.005 * beyond);
  filter.heat_of = config.branches.warmth_at[1];
  LONGS_EQUAL(cold, limit(cell, kLow, 30'000));
  filter.heat_of = config.branches.warmth_at[0] - Temperature::from_raw(10'000);  // never as warm as the law's begin
  LONGS_EQUAL(cold, limit(cell, kLow, 30'000));
}

TEST(Horizon, ACellWithoutResistanceIsHeldByTheMaximum) {
  for (CircuitPoint& point : filter.model.circuit) point.r0 = point.r1 = point.r2 = 0;
  for (const std::int32_t ms : {1'000, 30'000, 0}) LONGS_EQUAL(kMost, limit(rested(0.9), kLow, ms));
}

// A resistance beyond an ohm counts as that: it never wraps into none.
TEST(Horizon, LargeResistancesAllowLittleAndLess) {
  for (Resistance& r : config.branches.series) r = Resistance::from_raw(500'000);
  make_model(config, filter.model);
  std::int32_t last = kMost;
  for (double rho = 0.2; rho <= 5.0; rho += 0.1) {
    CellFilter cell = rested(0.6);
    cell.rho = raw(rho);
    const double volts = 3.71 - 3.4, ohm = std::min(0.5 * rho, 250.0 / 256.0) * 1.015;  // its law at no current
    const std::int32_t ma = limit(cell, kLow, 1'000, last);
    DOUBLES_EQUAL(1e3 * volts / ohm, ma, 0.01 * ma + 6.0);
    CHECK(ma <= last + 6);
    last = ma;
  }
}

namespace {

/// With and without what the cell's own heat does [V].
double gained_by_heat(const SocFilter& filter, const CellFilter& cell, const Config& config, std::int32_t ma) {
  Config cold = config;
  cold.heat_capacity_j_per_k = 0;
  const Duration time = Duration::from_ms(30'000);
  const Horizon without = make_horizon(cold, filter, time, heat_change(filter));
  const Horizon with = make_horizon(config, filter, time, heat_change(filter));
  const std::int32_t before = cell_end({filter, cell, without, 0}, ma).voltage;
  return 0.25 * std::ldexp(cell_end({filter, cell, with, 0}, ma).voltage - before, -kVoltageBits);
}

}  // namespace

// A resistance that falls with the temperature never takes more because the cell warms, whatever the branches held.
TEST(Horizon, HeatNeverMakesADischargeWorse) {
  filter.heat_known = true;
  filter.heat_of = Temperature::from_raw(250);
  double most = 0.0;
  for (int draw = 0; draw < 20'000; ++draw) {
    CellFilter cell = drawn();
    cell.v1 = raw(4.0 * uniform(-0.3, 0.3));
    cell.v2 = raw(4.0 * uniform(-0.3, 0.3));
    config.heat_capacity_j_per_k = draw % 3 == 0 ? 1 : (draw % 3 == 1 ? 30 : 1'000);
    const double gained = gained_by_heat(filter, cell, config, static_cast<std::int32_t>(uniform(0.0, kMost)));
    CHECK(gained >= -1e-6);
    most = std::max(most, gained);
  }
  CHECK(most > 0.05);
}

// The law ends 25 K above: a cell of hardly any heat capacity is there and no further.
TEST(Horizon, MoreHeatThanTheLawKnowsChangesNothing) {
  filter.heat_known = true;
  filter.heat_of = Temperature::from_raw(250);
  CellFilter cell = rested(0.6);
  config.heat_capacity_j_per_k = 10;
  const double far = gained_by_heat(filter, cell, config, 300'000);
  for (const std::int32_t capacity : {5, 2, 1}) {
    config.heat_capacity_j_per_k = capacity;
    DOUBLES_EQUAL(far, gained_by_heat(filter, cell, config, 300'000), 0.02 * far);
  }
}

TEST(Horizon, AnUnknownTemperatureWarmsNothing) {
  const std::int32_t cold = limit(rested(0.4), kLow, 30'000);
  config.heat_capacity_j_per_k = 60;
  LONGS_EQUAL(cold, limit(rested(0.4), kLow, 30'000));
  filter.heat_known = true;
  filter.heat_of = Temperature::from_raw(250);
  CHECK(limit(rested(0.4), kLow, 30'000) > cold);
}

// BMS-045: on curves with every bend that a model keeps, from wherever the search begins.
TEST(Horizon, TheCurrentStandsAtItsBoundOnAnyCurve) {
  for (int draw = 0; draw < 20'000; ++draw) {
    config.ocv.count = static_cast<std::uint8_t>(2 + draw % 9);
    double soc = 0.0, volts = uniform(1.0, 3.4);
    for (std::uint8_t i = 0; i < config.ocv.count; ++i) {
      config.ocv.soc[i] = Soc::from_raw(static_cast<std::int32_t>(1e6 * soc) + i);
      config.ocv.voltage[i] = CellVoltage::from_raw(static_cast<std::int32_t>(1e4 * volts) + i);
      const double part = (1.0 - soc) * std::pow(uniform(0.0, 1.0), 3.0) * 0.99;
      soc += part;
      volts += std::min(5.9 * part, (4.2 - volts) * std::pow(uniform(0.0, 1.0), 3.0));
    }
    make_model(config, filter.model);
    CellFilter cell = drawn();
    cell.rho = raw(uniform(0.2, 5.0));
    const Horizon horizon = make_horizon(config, filter, kLimitHorizons[draw % 4], heat_change(filter));
    for (const HorizonBound& bound : {kLow, kHigh}) {
      const auto from = static_cast<std::int32_t>(uniform(0.0, kMost));
      const HorizonCell here{filter, cell, horizon, prudent_fade(cell)};
      const std::int32_t ma = current_until(here, bound, from);
      CHECK(ma >= 0 && ma <= kMost);
      const std::int32_t sign = bound.direction == Direction::kDischarge ? 1 : -1;
      const double ends = 0.25 * std::ldexp(cell_end(here, sign * ma).voltage, -kVoltageBits);
      if (ma > 0) CHECK(sign * (ends - 1e-4 * bound.voltage.raw()) > -0.002);
    }
  }
}

// BMS-045: a curve that is steeper than its model keeps has a step, 0.5 V here, and the bound may lie within it.
TEST(Horizon, WhereTheCurveHasAStepTheLimitIsOnItsSafeSide) {
  config.ocv.count = 4;
  const std::int32_t soc[] = {0, 490'000, 500'000, 1'000'000}, volts[] = {30'000, 32'000, 38'000, 41'000};
  for (std::size_t i = 0; i < 4; ++i) {
    config.ocv.soc[i] = Soc::from_raw(soc[i]);
    config.ocv.voltage[i] = CellVoltage::from_raw(volts[i]);
  }
  make_model(config, filter.model);
  for (const double above : {0.001, 0.01, 0.05}) {  // down to the step in 30 s: 1.2 A, 12 A and 60 A of 10 Ah
    for (const std::int32_t from : {0, 1'000, 50'000, kMost}) {
      const std::int32_t ma = limit(rested(0.5 + above), kLow, 30'000, from);
      CHECK(ma <= 1.2e6 * above + 1.0);
      CHECK(ma >= 1.2e6 * above - 110.0);  // 400 A halved twelve times
    }
  }
}
