// SPDX-License-Identifier: Apache-2.0
// BMS-081: single steps of the filter beside its twin, from drawn states and covariances: every entry, so that an error
// of one is not hidden by what readings put right afterwards.
#include <array>
#include <cstdlib>
#include <random>
#include <string>

#include "estimate/filter_bench.hpp"
#include "estimate/filter_twin.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr std::size_t kStates = FilterTwin::kStates;

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : std::random_device{}();
}

std::int32_t rounded(double value, int bits) { return static_cast<std::int32_t>(std::lround(std::ldexp(value, bits))); }

}  // namespace

TEST_GROUP(CellStep) {
  Config config = filtered_config();
  CellModel model{};
  PartFactors warm{};
  CellFilter filter{};
  unsigned seed = drawn_seed();
  std::mt19937_64 random{seed};
  double worst_state[kStates] = {}, worst[kStates][kStates] = {};

  void setup() override { make_model(config, model); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

  /// A covariance that a filter may have: deviations over two decades, and what five drawn directions correlate.
  void draw() {
    filter = CellFilter{};
    filter.s = rounded(uniform(0.02, 0.98), kUnitBits);
    filter.v1 = rounded(uniform(-0.3, 0.3), kUnitBits);
    filter.v2 = rounded(uniform(-0.3, 0.3), kUnitBits);
    filter.rho = rounded(uniform(0.5, 2.0), kUnitBits);
    filter.fade = rounded(uniform(-0.2, 0.4), kUnitBits);
    double a[kStates][kStates], p[kStates][kStates] = {}, deviation[kStates];
    for (auto& row : a) {
      for (double& value : row) value = uniform(-1.0, 1.0);
    }
    for (double& value : deviation) value = std::pow(10.0, uniform(-2.4, -1.4));
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) {
        for (std::size_t j = 0; j < kStates; ++j) p[i][k] += a[i][j] * a[k][j] / 5.0 * deviation[i] * deviation[k];
      }
      p[i][i] += 1e-5;
    }
    const auto raw = [&](std::size_t i, std::size_t k) { return rounded(p[i][k], kVarianceBits); };
    filter.p = {raw(0, 0), raw(0, 1), raw(0, 2), raw(0, 3), raw(1, 1), raw(1, 2), raw(1, 3), raw(2, 2),
                raw(2, 3), raw(3, 3), raw(0, 4), raw(1, 4), raw(2, 4), raw(3, 4), raw(4, 4)};
    filter.apart = rounded(std::pow(uniform(-0.5, 0.5), 3), kUnitBits);
    warm = factors_of(model.by_temperature, static_cast<std::int32_t>(uniform(-100.0, 600.0)));
  }
  /// Of the state [2^-28] and of the covariance [2^-32].
  void compare(const FilterTwin& twin) {
    FilterTwin own(model);
    own.take(filter);
    for (std::size_t i = 0; i < kStates; ++i) {
      worst_state[i] = std::max(worst_state[i], std::ldexp(std::abs(own.x[i] - twin.x[i]), kUnitBits));
      for (std::size_t k = 0; k <= i; ++k) {
        worst[i][k] = std::max(worst[i][k], std::ldexp(std::abs(own.p[i][k] - twin.p[i][k]), kVarianceBits));
      }
    }
  }
  void check(double state_bound, double bound) {
    const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
    double most_state = 0.0, most = 0.0;
    for (std::size_t i = 0; i < kStates; ++i) {
      most_state = std::max(most_state, worst_state[i]);
      for (std::size_t k = 0; k <= i; ++k) most = std::max(most, worst[i][k]);
    }
    std::printf("BMS-081: %s, state within %.0f of 2^-28, covariance within %.0f of 2^-32\n", what.c_str(), most_state,
                most);
    CHECK_TEXT(most_state < state_bound, what.c_str());
    CHECK_TEXT(most < bound, what.c_str());
  }
};

TEST(CellStep, PredictsAsItsTwin) {
  for (int k = 0; k < 2'000; ++k) {
    draw();
    const auto ms = static_cast<std::int32_t>(uniform(1.0, 200.0));
    const auto ma = static_cast<std::int32_t>(uniform(-100'000.0, 300'000.0));
    FilterTwin twin(model);
    twin.take(filter);
    const FilterInterval interval{ms, rounded(1e-3 * ma * 1e-3 * ms / 36'000.0, kUnitBits), ma};
    predict_cell(model, warm, interval, filter);
    twin.predict(warm, interval);
    compare(twin);
  }
  check(2'500.0, 250.0);
}

TEST(CellStep, ReadsAsItsTwin) {
  for (int k = 0; k < 2'000; ++k) {
    draw();
    const auto ma = static_cast<std::int32_t>(uniform(-100'000.0, 300'000.0));
    FilterTwin twin(model);
    twin.take(filter);
    const FilterReading reading{CellVoltage::from_raw(static_cast<std::int32_t>(uniform(30'000.0, 42'000.0))), ma};
    update_cell(model, warm, reading, filter);
    twin.update(warm, reading);
    compare(twin);
  }
  check(2'500.0, 250.0);
}

// What grows by less than a step's rounding is seen over many.
TEST(CellStep, DoubtsGrowAtTheirRateWhileNothingIsRead) {
  constexpr int kSteps = 2'000, kStep_ms = 80;
  draw();
  begin_filter({}, filter);
  const CellCovariance before = filter.p;
  for (int k = 0; k < kSteps; ++k) predict_cell(model, warm, {kStep_ms, 0, 0}, filter);
  const double steps = kSteps * kStep_ms / 100.0;
  DOUBLES_EQUAL(430.0 * steps, filter.p.rr - before.rr, 0.01 * 430.0 * steps);
  DOUBLES_EQUAL(4.0 * steps, filter.p.ff - before.ff, 0.1 * 4.0 * steps);
  LONGS_EQUAL(before.ss, filter.p.ss);
}

// The mean of the last readings: an eighth of what is left each time.
TEST(CellStep, MissFollowsWhatAReadingIsBesideTheModel) {
  draw();
  filter.v1 = filter.v2 = filter.miss = 0;
  filter.s = kUnit / 2;
  filter.rho = kUnit;
  begin_filter({}, filter);
  CellFilter here = filter;
  const std::int32_t ocv = ocv_at(model, here.s, here.interval).voltage;
  const double above_v = 0.02;  // of a quarter volt 0.08
  const auto raw = static_cast<std::int32_t>(std::lround(1e4 * (0.25 * std::ldexp(ocv, -kVoltageBits) + above_v)));
  update_cell(model, warm, {CellVoltage::from_raw(raw), 0}, filter);
  DOUBLES_EQUAL(0.08 / 8.0, std::ldexp(filter.miss, -kUnitBits), 1e-4);
  filter.s = here.s;
  filter.v1 = filter.v2 = 0;
  update_cell(model, warm, {CellVoltage::from_raw(raw), 0}, filter);
  DOUBLES_EQUAL(0.08 * (1.0 - 49.0 / 64.0), std::ldexp(filter.miss, -kUnitBits), 2e-4);
}

TEST(CellStep, WhatLastsIsTheMeanOf128Readings) {
  draw();
  filter.apart = 0;
  begin_filter({}, filter);
  CellFilter here = filter;
  update_cell(model, warm, {CellVoltage::from_raw(45'000), 0}, filter);  // beyond all: 250 mV
  LONGS_EQUAL(kUnit / 128, filter.apart);
  const std::int32_t before = filter.apart;
  filter = here;
  filter.apart = before;
  update_cell(model, warm, {CellVoltage::from_raw(20'000), 0}, filter);
  LONGS_EQUAL(before + (-kUnit - before) / 128, filter.apart);
}

// BMS-082: the first reading after a start from a record, one step of 0.1 mV on either side of two deviations.
TEST(CellStep, ARecordThatTheFirstReadingContradictsIsDoubtedByAQuarterOfTheCharge) {
  int contradicted = 0, believed = 0;
  for (int k = 0; k < 500; ++k) {
    draw();
    filter.apart = 0;
    filter.from_record = true;
    const auto ma = static_cast<std::int32_t>(uniform(-100'000.0, 300'000.0));
    const FilterReading reading{CellVoltage::from_raw(static_cast<std::int32_t>(uniform(30'000.0, 42'000.0))), ma};
    FilterTwin twin(model);
    twin.take(filter);
    twin.update(warm, reading);
    const CellFilter before = filter;
    update_cell(model, warm, reading, filter);
    CHECK(!filter.from_record);
    if (filter.p.ss == 268'435'456) {
      ++contradicted;
      LONGS_EQUAL(before.s, filter.s);
      LONGS_EQUAL(before.rho, filter.rho);
      LONGS_EQUAL(before.miss, filter.miss);
      LONGS_EQUAL(0, filter.apart);
      LONGS_EQUAL(before.p.v11, filter.p.v11);
    } else {
      ++believed;
    }
    compare(twin);
    CellFilter again = before;
    again.from_record = false;
    update_cell(model, warm, reading, again);
    CHECK(again.p.ss != 268'435'456);
  }
  check(2'500.0, 250.0);
  CHECK(contradicted > 50 && believed > 50);
}

TEST(CellStep, AStartKnowsOfNoCorrelation) {
  draw();
  begin_filter({1 << 20, 1 << 21, 1 << 22, 1 << 23, 1 << 24}, filter);
  const CellCovariance& p = filter.p;
  for (const std::int32_t raw : {p.s1, p.s2, p.sr, p.v12, p.v1r, p.v2r, p.sf, p.v1f, p.v2f, p.rf}) LONGS_EQUAL(0, raw);
  LONGS_EQUAL(1 << 20, p.ss);
  LONGS_EQUAL(1 << 24, p.ff);
}

// A filter that is sure learns nothing more.
TEST(CellStep, NoVarianceFallsBelowItsLeast) {
  constexpr std::int32_t kLeast = 4'096;
  warm = PartFactors{};
  begin_filter({}, filter);
  const auto variances = [&] { return std::array{filter.p.ss, filter.p.v11, filter.p.v22, filter.p.rr, filter.p.ff}; };
  for (const std::int32_t variance : variances()) LONGS_EQUAL(kLeast, variance);
  for (int k = 0; k < 300; ++k) {
    filter.s = kUnit / 20;  // where the curve is steep
    filter.apart = 0;
    update_cell(model, warm, {CellVoltage::from_raw(30'000), 200'000}, filter);
    for (const std::int32_t variance : variances()) CHECK(variance >= kLeast);
  }
  LONGS_EQUAL(kLeast, filter.p.ss);
}
