// SPDX-License-Identifier: Apache-2.0
// Where a cell ends: the integers beside their twin in double precision.
#include <random>

#include "estimate/filter_bench.hpp"
#include "limits/horizon_twin.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

std::int32_t raw(double x) { return static_cast<std::int32_t>(std::lround(std::ldexp(x, kUnitBits))); }
double volts(const CellEnd& end) { return 0.25 * std::ldexp(end.voltage, -kVoltageBits); }
double ohm(const CellEnd& end) { return 250.0 * std::ldexp(end.fall, -kUnitBits - kOhmBits); }

/// Everything changes with everything.
Config changing_config() {
  Config c = filtered_config();
  c.branches.current_min = amps(20);
  c.branches.per_ampere = {-800, -1'500, 700, -1'000, 900};
  straight_warmth({-10'000, -15'000, -12'000, -8'000, 9'000}, c);
  const std::int32_t percent[] = {250, 80, 130};
  for (std::size_t i = 0; i < 3; ++i) {
    c.branches.series[i] = Resistance::from_raw(10 * percent[i]);
    c.branches.branch1[i] = Resistance::from_raw(5 * percent[i]);
    c.branches.branch2[i] = Resistance::from_raw(8 * percent[2 - i]);
    c.branches.time1[i] = Duration::from_ms(20 * percent[i]);
    c.branches.time2[i] = Duration::from_ms(300 * percent[2 - i]);
  }
  return c;
}

}  // namespace

TEST_GROUP(HorizonEnd) {
  Config config = changing_config();
  SocFilter filter{};
  CellFilter cell{};
  HorizonTwin twin{filter.model};
  std::mt19937_64 random{7};

  void setup() override {
    make_model(config, filter.model);
    filter.charge_bits = 36;  // 10 Ah, as soc_ekf does
    filter.per_charge = static_cast<std::int32_t>(std::lround(std::ldexp(1.0, 28 + 36) / (10'000.0 * 7.2e6)));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  void is_at(double celsius) {
    filter.heat_known = true;
    filter.heat_of = Temperature::from_raw(static_cast<std::int32_t>(std::lround(10.0 * celsius)));
    filter.warm = factors_of(filter.model.by_temperature, filter.heat_of.raw());
    twin.temperature = 0.1 * filter.heat_of.raw();
    twin.warm = filter.warm;
  }
  void draw() {
    is_at(uniform(-5.0, 55.0));
    config.heat_capacity_j_per_k = static_cast<std::int32_t>(std::exp(uniform(2.0, 6.0)));
    twin.seconds = 1e-3 * kLimitHorizons[random() % 3].ms();
    twin.soc = uniform(0.0, 1.0);
    twin.v1 = uniform(-0.1, 0.1), twin.v2 = uniform(-0.1, 0.1);
    twin.rho = uniform(0.4, 3.0), twin.fade = uniform(-0.2, 0.4), twin.miss = uniform(-0.03, 0.03);
    twin.warmer = 0.1 * std::floor(uniform(-50.0, 80.0));
  }
  CellEnd end(std::int32_t ma) {
    cell.s = raw(twin.soc), cell.v1 = raw(4.0 * twin.v1), cell.v2 = raw(4.0 * twin.v2);
    cell.rho = raw(twin.rho), cell.miss = raw(4.0 * twin.miss);
    twin.joules_per_k = config.heat_capacity_j_per_k;
    const Duration time = Duration::from_ms(static_cast<std::int32_t>(std::lround(1e3 * twin.seconds)));
    const Horizon horizon = make_horizon(config, filter, time, heat_change(filter));
    const auto warmer = static_cast<std::int32_t>(std::lround(10.0 * twin.warmer));
    return cell_end({filter, cell, horizon, raw(twin.fade), warmer}, ma);
  }
  /// How far apart the two are, in shares: of the drop and 50 mV, and of the slope.
  struct Apart {
    double drop = 0.0, slope = 0.0;
  };
  void compare(std::int32_t ma, Apart& most) {
    const CellEnd found = end(ma);
    const HorizonTwin::End exact = twin.end(1e-3 * ma);
    most.drop = std::max(most.drop, std::abs(volts(found) - exact.voltage) / (0.05 + std::abs(exact.drop)));
    most.slope = std::max(most.slope, std::abs(ohm(found) / exact.ohm - 1.0));
  }
};

// BMS-045
TEST(HorizonEnd, IsThatOfDoublePrecisionInWhateverState) {
  Apart most;
  for (int n = 0; n < 10'000; ++n) {
    draw();
    compare(static_cast<std::int32_t>(uniform(-400'000.0, 400'000.0)), most);
  }
  CHECK(most.drop < 0.0004);
  CHECK(most.slope < 0.00025);
}

// BMS-045: at both of its ends too, where the slope is that of a resistance which stays.
TEST(HorizonEnd, BeyondTheEndsOfItsLawAResistanceDoesNotChangeWithTheCurrent) {
  for (std::size_t i = 0; i < 3; ++i) {
    config.branches.series[i] = Resistance::from_raw(300'000);  // so much that a milliampere's share of it is seen
    config.branches.branch1[i] = config.branches.branch2[i] = Resistance{};
  }
  config.branches.per_ampere.series = -3'000;
  make_model(config, filter.model);
  twin.seconds = 0.0;
  for (const std::int32_t ma : {1'000, 19'999, 20'000, 300'000, 300'001, 400'000}) {
    const double factor = 1.0 - 0.003 * (std::min(std::max(1e-3 * ma, 20.0), 300.0) - 50.0);
    DOUBLES_EQUAL(0.3 * factor, ohm(end(ma)), 1e-6);
    for (const std::int32_t sign : {1, -1}) DOUBLES_EQUAL(twin.end(1e-3 * ma).ohm, ohm(end(sign * ma)), 1e-7);
  }
  for (const std::int32_t ma : {20'001, 120'000, 299'999}) {  // R I bends twice as much
    DOUBLES_EQUAL(0.3 * (1.15 - 0.006e-3 * ma), ohm(end(ma)), 4e-6);
    for (const std::int32_t sign : {1, -1}) DOUBLES_EQUAL(twin.end(1e-3 * ma).ohm, ohm(end(sign * ma)), 1e-7);
  }
}

// BMS-045
TEST(HorizonEnd, AResistanceThatGrowsWithTheHeatGrowsByHalfAtMost) {
  config.branches.warmth_at[0] = Temperature::from_raw(250);
  config.branches.warmth[0] = config.branches.warmth[1] = PartShares{};
  config.branches.warmth[1].series = 2'500'000;  // 6 % a kelvin
  config.branches.branch1[0] = config.branches.branch1[1] = config.branches.branch1[2] = Resistance{};
  config.branches.branch2[0] = config.branches.branch2[1] = config.branches.branch2[2] = Resistance{};
  make_model(config, filter.model);
  is_at(25.0);
  twin.soc = 0.6;
  twin.seconds = 10.0;
  config.heat_capacity_j_per_k = 0;
  const double cold = volts(end(0)) - volts(end(150'000));
  double last = cold;
  for (const std::int32_t capacity : {1'000, 300, 100, 60, 30, 10}) {
    config.heat_capacity_j_per_k = capacity;
    const double drop = volts(end(0)) - volts(end(150'000));
    CHECK(capacity < 30 ? drop == last : drop > last);
    DOUBLES_EQUAL(twin.end(150.0).voltage, volts(end(150'000)), 1e-4);
    last = drop;
  }
  const double charge = 0.3 * 1'500.0 / 36'000.0;  // what the OCV falls by meanwhile is no drop
  DOUBLES_EQUAL(1.5 * (cold - charge), last - charge, 1e-4);
}

// BMS-045
TEST(HorizonEnd, WhatAKelvinChangesIsAShareOfWhatTheResistanceIsNowButOfATenthAtLeast) {
  const PartFactors per_count = slope_of(filter.model.by_temperature, filter.heat_of.raw());
  const auto share = [&](std::int32_t now) {
    filter.warm = {now, now, now, now, now};
    return heat_change(filter);
  };
  LONGS_EQUAL(per_count.r0, share(kUnit).r0);
  LONGS_EQUAL(per_count.time2, share(kUnit).time2);
  LONGS_EQUAL(2 * per_count.r1, share(kUnit / 2).r1);
  LONGS_EQUAL(8 * per_count.time1, share(kUnit / 8).time1);
  DOUBLES_EQUAL(10.0 * per_count.r2, share(kUnit / 10).r2, 100.0);
  LONGS_EQUAL(share(kUnit / 10).r2, share(kUnit / 20).r2);
  LONGS_EQUAL(share(kUnit / 10).r0, share(-kUnit).r0);
}

TEST(HorizonEnd, TheFadeIsTakenWithItsStandardDeviation) {
  for (const std::int32_t deviation : {0, 1, 2, 3, 63, 64, 1'000, 21'474, 32'768}) {  // [2^-16]
    CellFilter known;
    known.fade = -kUnit / 8;
    known.p.ff = deviation * deviation;
    const auto of = [](std::int32_t parts) { return -kUnit / 8 + parts * (1 << 12); };
    LONGS_EQUAL(of(deviation), prudent_fade(known));
    known.p.ff += 2 * deviation;
    LONGS_EQUAL(of(deviation), prudent_fade(known));
    known.p.ff += 1;
    LONGS_EQUAL(of(deviation + 1), prudent_fade(known));
  }
  CellFilter none;
  none.fade = kFadeHigh;
  none.p.ff = 1 << 30;
  LONGS_EQUAL(kFadeHigh, prudent_fade(none));
}
