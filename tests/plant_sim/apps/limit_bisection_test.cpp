// SPDX-License-Identifier: Apache-2.0
// The integers of firmware/bms/limits/horizon.cpp beside the bisection in double precision, over drawn packs and
// states.
#include "apps/limit_bisection.hpp"

#include <CppUTest/TestHarness.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

/// States of the comparison: 10 million with VOLTLAP_HORIZON_STATES=10000000.
long states_asked() {
  const char* given = std::getenv("VOLTLAP_HORIZON_STATES");
  return given == nullptr ? 200'000 : std::atol(given);
}

std::int32_t raw(double x) { return static_cast<std::int32_t>(std::lround(std::ldexp(x, bms::kUnitBits))); }

struct Draw {
  std::mt19937_64 random{11};
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }

  /// Cells of 1 to 200 Ah, with resistances that fit them.
  bms::Config config() {
    bms::Config c;
    const double ah = std::exp(uniform(std::log(1.0), std::log(200.0))), uohm = 100'000.0 / ah;
    c.capacity_mah = static_cast<std::int32_t>(1e3 * ah);
    c.ocv.count = static_cast<std::uint8_t>(whole(3, 20));
    double volts = uniform(2.5, 3.2);
    for (int i = 0; i < c.ocv.count; ++i) {
      c.ocv.soc[i] = Soc::from_raw(1'000'000 / (c.ocv.count - 1) * i);
      c.ocv.voltage[i] = CellVoltage::from_raw(static_cast<std::int32_t>(1e4 * volts));
      volts += uniform(0.001, 2.0 / c.ocv.count);
    }
    c.ocv.soc[c.ocv.count - 1] = Soc::from_raw(1'000'000);
    c.resistance.count = 5;
    for (int i = 0; i < 5; ++i) {
      c.resistance.soc[i] = Soc::from_raw(250'000 * i);
      const auto part = [&] { return Resistance::from_raw(static_cast<std::int32_t>(uohm * uniform(0.1, 1.0))); };
      c.branches.series[i] = part(), c.branches.branch1[i] = part(), c.branches.branch2[i] = part();
      c.branches.time1[i] = Duration::from_ms(whole(500, 10'000));
      c.branches.time2[i] = Duration::from_ms(whole(10'000, 3'000'000));
    }
    const auto most = static_cast<std::int32_t>(1e4 * ah);  // 10 C
    c.branches.current_max = Current::from_raw(most);
    c.branches.current_reference = Current::from_raw(most / 4);
    // By a tenth over all of the range: the voltage still falls with the current.
    const std::int32_t slope = -static_cast<std::int32_t>(1e5 / (1e-3 * most));
    c.branches.per_ampere = {slope, slope, slope, slope / 2, slope};
    c.branches.warmth_count = 3;
    const std::int32_t at[] = {-100, 100, 450};  // [0.1 degC]
    const bms::PartShares shares[] = {{1'600'000, 2'100'000, 1'700'000, 1'300'000, 1'000'000},
                                      {1'200'000, 1'300'000, 1'250'000, 1'100'000, 1'000'000},
                                      {800'000, 700'000, 760'000, 900'000, 1'000'000}};
    for (int i = 0; i < 3; ++i) {
      c.branches.warmth_at[i] = Temperature::from_raw(at[i]);
      c.branches.warmth[i] = shares[i];
    }
    c.heat_capacity_j_per_k = whole(0, 3) == 0 ? 0 : std::max(10, static_cast<int>(25.0 * ah));
    return c;
  }
  bms::CellFilter cell() {
    bms::CellFilter f;
    f.s = raw(uniform(-0.03, 1.03));
    f.v1 = raw(4.0 * uniform(-0.1, 0.1));
    f.v2 = raw(4.0 * uniform(-0.1, 0.1));
    f.rho = raw(uniform(0.3, 3.0));
    f.fade = raw(uniform(-0.2, 0.4));
    f.p.ff = whole(4'096, 42'949'673);  // 0.1 %, 10 %
    f.miss = raw(4.0 * uniform(-0.02, 0.02));
    return f;
  }
};

/// As soc_ekf makes it.
void fill_charge(const bms::Config& config, bms::SocFilter& filter) {
  const double full = config.capacity_mah * 7.2e6;
  filter.charge_bits = static_cast<std::uint8_t>(std::floor(std::log2(full)));
  filter.per_charge = static_cast<std::int32_t>(std::ldexp(1.0, filter.charge_bits + 28) / full);
}

}  // namespace

TEST_GROUP(LimitBisection) {
  Draw draw;
};

// BMS-045
TEST(LimitBisection, TheIntegersAreWithinHalfAPerCentOfItOrAFewMilliamperes) {
  bms::Config config;
  static bms::SocFilter filter;
  long voltage_binds = 0;
  double worst_v = 0.0;
  const long states = states_asked();
  for (long n = 0; n < states; ++n) {
    if (n % 200 == 0) {
      config = draw.config();
      bms::make_model(config, filter.model);
      fill_charge(config, filter);
      filter.heat_known = true;
      filter.heat_of = Temperature::from_raw(draw.whole(-200, 500));
      filter.warm = bms::factors_of(filter.model.by_temperature, filter.heat_of.raw());
    }
    filter.cell[0].filter = draw.cell();
    const Duration time = bms::kLimitHorizons[static_cast<std::size_t>(draw.whole(0, 3))];
    const bool discharge = draw.whole(0, 1) == 0;
    const auto at = [&](double v) { return CellVoltage::from_raw(static_cast<std::int32_t>(1e4 * v)); };
    const bms::HorizonBound bound =
        discharge ? bms::HorizonBound{bms::Direction::kDischarge, at(draw.uniform(2.2, 3.2)), config.capacity_mah * 10}
                  : bms::HorizonBound{bms::Direction::kCharge, at(draw.uniform(3.6, 4.5)), config.capacity_mah * 5};
    const bms::Horizon horizon = bms::make_horizon(config, filter, time, bms::heat_change(filter));
    const std::int32_t from = draw.whole(0, bound.most_ma);
    const std::int32_t warmer = draw.whole(-50, 50);
    const bms::CellFilter& own = filter.cell[0].filter;
    const bms::HorizonCell cell{filter, own, horizon, bms::prudent_fade(own), warmer};
    const double found = bms::current_until(cell, bound, from);
    const LimitBisection twin(config, filter, 0, time, warmer);
    const double exact = twin.current_ma(bound);
    if (exact < bound.most_ma) ++voltage_binds;
    const double close = 0.005 * exact + 0.0002 * bound.most_ma, size = discharge ? found : -found;
    // Where the voltage hardly falls with the current, as a cell that warms itself, it counts: 1 mV.
    const double bound_v = 1e-4 * bound.voltage.raw(), end_v = twin.end_v(size);
    const double integers_v = 0.25 * std::ldexp(bms::cell_end(cell, static_cast<std::int32_t>(size)).voltage,
                                                -bms::kVoltageBits);
    CHECK_TRUE_TEXT(std::abs(found - exact) <= close || std::abs(end_v - bound_v) <= 0.001,
                    fmt::format("state {}: {} for {:.0f} mA, of {} mAh, for {} ms {}; at the end {:.5f}, by the "
                                "integers {:.5f}, of {:.4f} V",
                                n, found, exact, config.capacity_mah, time.ms(), discharge ? "out" : "in", end_v,
                                integers_v, bound_v)
                        .c_str());
    worst_v = std::max(worst_v, std::abs(end_v - integers_v));
  }
  // BMS-045
  std::printf("BMS-045: integers and double precision %.2f mV apart at most, in %ld states\n", 1e3 * worst_v, states);
  CHECK(worst_v < 0.0015);
  CHECK(voltage_binds > states / 4);
}
