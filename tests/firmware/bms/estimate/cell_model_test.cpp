// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/cell_model.hpp"

#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

double unit(std::int32_t raw) { return std::ldexp(raw, -kUnitBits); }
std::int32_t soc_of(double soc) { return static_cast<std::int32_t>(std::lround(std::ldexp(soc, kUnitBits))); }

/// Member by member: what lies between them is nobody's.
void check_same(const CellModel& a, const CellModel& b) {
  MEMCMP_EQUAL(a.ocv_soc, b.ocv_soc, sizeof a.ocv_soc);
  MEMCMP_EQUAL(a.ocv, b.ocv, sizeof a.ocv);
  MEMCMP_EQUAL(a.ocv_slope, b.ocv_slope, sizeof a.ocv_slope);
  LONGS_EQUAL(a.intervals, b.intervals);
  MEMCMP_EQUAL(a.circuit, b.circuit, sizeof a.circuit);
  LONGS_EQUAL(a.points, b.points);
  MEMCMP_EQUAL(&a.by_current, &b.by_current, sizeof a.by_current);
  MEMCMP_EQUAL(&a.by_temperature, &b.by_temperature, sizeof a.by_temperature);
}

}  // namespace

TEST_GROUP(CellModel) {
  Config config = filtered_config();
  CellModel model{};
  std::uint8_t interval = 0;
  void setup() override { make_model(config, model); }
  double ocv_v(double soc) { return 0.25 * std::ldexp(ocv_at(model, soc_of(soc), interval).voltage, -kVoltageBits); }
};

TEST(CellModel, ReadsTheOcvOfTheConfigurationFromWhereverTheLastSearchEnded) {
  for (const double soc : {0.0, 1.0, 0.1, 0.55, 0.05, 0.4, 0.99, 0.7, 0.2}) {
    const CellVoltage table =
        interpolate(config.ocv.soc, config.ocv.voltage, config.ocv.count, Soc::from_raw(static_cast<int>(1e6 * soc)));
    DOUBLES_EQUAL(1e-4 * table.raw(), ocv_v(soc), 6e-5);
  }
}

TEST(CellModel, GrownInTurnsItIsTheOneThatIsMadeAtOnce) {
  CellModel grown{};
  int turns = 1;
  for (; !grow_model(config, grown); ++turns) CHECK(grown.points > 0 && grown.points <= kCircuitSteps);
  LONGS_EQUAL(3, turns);
  check_same(model, grown);
  CHECK(grow_model(config, grown));
  check_same(model, grown);
}

TEST(CellModel, GoesOnWithTheEndsSlopeBeyondTheTable) {
  DOUBLES_EQUAL(3.0 - 0.05 * 4.5, ocv_v(-0.05), 1e-5);
  DOUBLES_EQUAL(4.18 + 0.05 * 0.44 / 0.3, ocv_v(1.05), 1e-5);
}

TEST(CellModel, HoldsASlopeThatIsSteeperThanSixVoltsOverTheCharge) {
  config.ocv.voltage[1] = CellVoltage::from_raw(36'400);
  make_model(config, model);
  (void)ocv_v(0.05);
  LONGS_EQUAL(0, interval);
  DOUBLES_EQUAL(6.0, 0.25 * std::ldexp(ocv_at(model, soc_of(0.05), interval).slope, -kSlopeBits), 1e-6);
}

TEST(CellModel, AResistanceTakesItsVolts) {
  const CircuitPoint p = branches_at(model, soc_of(0.6));
  const std::int32_t r0 = series_at(model, soc_of(0.6));
  DOUBLES_EQUAL(0.001 * 123.456, 0.25 * unit(drop_of(r0, 123'456)), 1e-6);
  DOUBLES_EQUAL(-0.0004 * 20.0, 0.25 * unit(drop_of(p.r1, -20'000)), 1e-6);
  DOUBLES_EQUAL(2.0, 0.25 * unit(drop_of(r0, 1'000'000'000)), 1e-6);  // held
}

TEST(CellModel, ReadsTheCircuitBetweenItsPointsAndHoldsItBeyondTheEnds) {
  const auto ohm = [&](double soc) { return 0.25 * unit(drop_of(series_at(model, soc_of(soc)), 1'000)); };
  DOUBLES_EQUAL(0.002, ohm(-0.05), 1e-7);
  DOUBLES_EQUAL(0.0015, ohm(0.1), 2e-6);  // the table's knee lies between two of the 33 points
  DOUBLES_EQUAL(0.001, ohm(1.05), 1e-7);
  DOUBLES_EQUAL(1.0 / 60'000.0, std::ldexp(branches_at(model, soc_of(0.5)).rate2, -kRateBits), 1e-10);
}

TEST(CellModel, PartsChangeWithCurrentAndTemperatureWithinTheirRanges) {
  const PartFactors far = factors_of(model.by_current, 900'000);
  DOUBLES_EQUAL(1.0 - 0.0003 * 250, unit(far.r0), 1e-4);
  DOUBLES_EQUAL(1.0 - 0.0015 * 250, unit(far.r1), 1e-4);
  DOUBLES_EQUAL(1.0, unit(far.r2), 1e-9);
  DOUBLES_EQUAL(1.0 - 0.001 * 250, unit(far.time1), 1e-4);
  const PartFactors cold = factors_of(model.by_temperature, -200);
  DOUBLES_EQUAL(1.0 + 0.01 * 25, unit(cold.r0), 1e-4);
  DOUBLES_EQUAL(1.0 + 0.015 * 25, unit(cold.r1), 1e-4);
  DOUBLES_EQUAL(unit(cold.r1), unit(factors_of(model.by_temperature, 0).r1), 1e-9);
}

// A curve that bends: Arrhenius' law of 50 kJ/mol at six temperatures.
TEST(CellModel, WarmthIsStraightBetweenItsPointsAndAsAtItsEndsBeyondThem) {
  const std::int32_t shares[] = {7'500'000, 3'800'000, 2'150'000, 1'000'000, 512'000, 280'000};
  const std::int32_t at[] = {-100, 0, 100, 250, 400, 550};
  config.branches.warmth_count = 6;
  for (std::size_t i = 0; i < 6; ++i) {
    config.branches.warmth_at[i] = Temperature::from_raw(at[i]);
    config.branches.warmth[i] = {shares[i], 1'000'000, shares[i], 1'000'000, shares[5 - i]};
  }
  make_model(config, model);
  const WarmthCurve& curve = model.by_temperature;
  double last = 8.0;
  for (std::int32_t counts = -200; counts <= 700; ++counts) {
    const double inside = std::clamp<double>(counts, at[0], at[5]);
    std::size_t i = 0;
    while (i < 4 && inside >= at[i + 1]) ++i;
    const double share = shares[i] + (inside - at[i]) / (at[i + 1] - at[i]) * (shares[i + 1] - shares[i]);
    const PartFactors f = factors_of(curve, counts);
    DOUBLES_EQUAL(1e-6 * share, unit(f.r0), 8e-6);
    LONGS_EQUAL(f.r0, f.r2);
    LONGS_EQUAL(kUnit, f.r1);
    LONGS_EQUAL(kUnit, f.time1);
    CHECK(unit(f.r0) <= last);
    last = unit(f.r0);
    if (counts < at[0] || counts >= at[5]) continue;
    const double slope = 1e-6 * (shares[i + 1] - shares[i]) / (at[i + 1] - at[i]);
    DOUBLES_EQUAL(std::max(slope, -1.0 / 32.0), std::ldexp(slope_of(curve, counts).r0, -kLawBits), 1e-9);
  }
  const PartFactors& beyond = slope_of(curve, 550);
  for (const std::int32_t slope : {beyond.r0, beyond.r1, beyond.r2, beyond.time1, beyond.time2}) LONGS_EQUAL(0, slope);
  LONGS_EQUAL(slope_of(curve, -100).time2, slope_of(curve, -2'000).time2);
}

TEST(CellModel, OneTemperatureSaysNothingOfOthers) {
  config.branches.warmth_count = 1;
  make_model(config, model);
  for (const std::int32_t counts : {-400, 0, 250, 900}) {
    LONGS_EQUAL(static_cast<std::int32_t>(1.25 * kUnit), factors_of(model.by_temperature, counts).r0);
    LONGS_EQUAL(0, slope_of(model.by_temperature, counts).r0);
  }
}

TEST(CellModel, UnitsOfTheBusAreThoseOfTheFilter) {
  DOUBLES_EQUAL(4.1999, 0.25 * std::ldexp(filter_voltage(CellVoltage::from_raw(41'999)), -kVoltageBits), 1e-8);
  DOUBLES_EQUAL(0.123456, unit(filter_soc(Soc::from_raw(123'456))), 1e-8);
  LONGS_EQUAL(123'456, reported_soc(filter_soc(Soc::from_raw(123'456))).raw());
  LONGS_EQUAL(0, reported_soc(-5).raw());
  LONGS_EQUAL(1'000'000, reported_soc(kUnit + 1'000).raw());
}

TEST(CellModel, APointOfTheCurveBelongsToTheIntervalAboveIt) {
  make_model(config, model);
  for (std::uint8_t from = 0; from < model.intervals; ++from) {
    std::uint8_t at = from;
    LONGS_EQUAL(model.ocv_slope[2], ocv_at(model, model.ocv_soc[2], at).slope);
    LONGS_EQUAL(2, at);
    LONGS_EQUAL(model.ocv_slope[1], ocv_at(model, model.ocv_soc[2] - 1, at).slope);
  }
}

TEST(CellModel, EveryPointOfTheTableHasItsOwnTimes) {
  config.branches.time1[0] = Duration::from_ms(1'000);
  config.branches.time2[0] = Duration::from_ms(20'000);
  make_model(config, model);
  DOUBLES_EQUAL(3.0, 1.0 * branches_at(model, 0).rate1 / branches_at(model, kUnit).rate1, 1e-3);
  DOUBLES_EQUAL(3.0, 1.0 * branches_at(model, 0).rate2 / branches_at(model, kUnit).rate2, 1e-3);
}
