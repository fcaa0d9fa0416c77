// SPDX-License-Identifier: Apache-2.0
// The current that ends at the bound: what is found from any first guess beside a bisection of the same cell.
#include <random>

#include "bms/limits/horizon.hpp"
#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr std::int32_t kMost = 400'000;
constexpr HorizonBound kLow{Direction::kDischarge, CellVoltage::from_raw(32'000), kMost};
constexpr HorizonBound kHigh{Direction::kCharge, CellVoltage::from_raw(40'000), kMost};

std::int32_t raw(double x) { return static_cast<std::int32_t>(std::lround(std::ldexp(x, kUnitBits))); }

/// The largest that ends within the bound, and not beyond empty or full.
std::int32_t bisected(const HorizonCell& cell, const HorizonBound& bound) {
  const std::int32_t sign = bound.direction == Direction::kDischarge ? 1 : -1;
  const auto within = [&](std::int32_t ma) {
    const double charge = std::ldexp(cell.filter.s, -kUnitBits), fade = std::ldexp(cell.fade, -kUnitBits);
    const double drawn = std::ldexp(cell.horizon.share, -44) * (1.0 + fade) * ma;
    const std::int32_t end = cell_end(cell, sign * ma).voltage;
    return sign > 0 ? end >= filter_voltage(bound.voltage) && drawn <= charge
                    : end <= filter_voltage(bound.voltage) && drawn <= 1.0 - charge;
  };
  if (within(bound.most_ma)) return bound.most_ma;
  std::int32_t low = 0, high = bound.most_ma;
  while (high - low > 1) (within((low + high) / 2) ? low : high) = (low + high) / 2;
  return low;
}

}  // namespace

TEST_GROUP(HorizonCurrent) {
  Config config = filtered_config();
  SocFilter filter{};
  CellFilter cell{};
  Horizon horizon{};
  std::mt19937_64 random{3};

  void setup() override {
    make_model(config, filter.model);
    filter.charge_bits = 36;  // 10 Ah, as soc_ekf does
    filter.per_charge = static_cast<std::int32_t>(std::lround(std::ldexp(1.0, 28 + 36) / (10'000.0 * 7.2e6)));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  void for_time(std::int32_t ms) {
    horizon = make_horizon(config, filter, Duration::from_ms(ms), heat_change(filter));
  }
  HorizonCell here() const { return {filter, cell, horizon, prudent_fade(cell)}; }
  /// A curve of flat and steep pieces.
  void draw_curve() {
    config.ocv.count = 12;
    double volts = 2.6;
    for (std::uint8_t i = 0; i < config.ocv.count; ++i) {
      config.ocv.soc[i] = Soc::from_raw(1'000'000 / 11 * i);
      config.ocv.voltage[i] = CellVoltage::from_raw(static_cast<std::int32_t>(1e4 * volts));
      volts += random() % 2 == 0 ? uniform(0.002, 0.03) : uniform(0.1, 0.35);
    }
    config.ocv.soc[11] = Soc::from_raw(1'000'000);
    make_model(config, filter.model);
  }
  void draw_cell() {
    cell.s = raw(uniform(0.0, 1.0));
    cell.v1 = raw(4.0 * uniform(-0.05, 0.05));
    cell.v2 = raw(4.0 * uniform(-0.05, 0.05));
    cell.rho = raw(std::exp(uniform(std::log(0.2), std::log(5.0))));
    cell.fade = raw(uniform(-0.2, 0.3));
    for_time(kLimitHorizons[random() % 4].ms());
  }
};

// BMS-045
TEST(HorizonCurrent, IsThatOfABisectionFromWhateverItWasTheLastTime) {
  int binds = 0;
  for (int n = 0; n < 3'000; ++n) {
    if (n % 20 == 0) draw_curve();
    draw_cell();
    for (const HorizonBound& bound : {kLow, kHigh}) {
      const std::int32_t exact = bisected(here(), bound);
      if (exact > 0 && exact < kMost) ++binds;
      for (const std::int32_t from : {0, kMost, static_cast<std::int32_t>(uniform(0.0, kMost)), exact}) {
        const std::int32_t found = current_until(here(), bound, from);
        CHECK(found >= 0 && found <= kMost);
        const double size = exact + 10'000.0;
        CHECK(found - exact < 0.001 * size && exact - found < 0.002 * size);
      }
    }
  }
  CHECK(binds > 1'000);
}

// BMS-045
TEST(HorizonCurrent, ACellThatRestsALittleBeyondItsBoundGivesNotAMilliampere) {
  for (Resistance& r : config.branches.series) r = Resistance::from_raw(200'000);
  make_model(config, filter.model);
  cell.s = raw(0.5);
  for_time(1'000);
  HorizonBound bound = kLow;
  const double volts = 0.25 * std::ldexp(cell_end(here(), 0).voltage, -kVoltageBits);
  for (const std::int32_t rho : {kUnit, 5 * kUnit}) {
    cell.rho = rho;
    for (const std::int32_t beyond : {1, 3, 10, 100}) {  // [0.1 mV]
      bound.voltage = CellVoltage::from_raw(static_cast<std::int32_t>(std::lround(1e4 * volts)) + beyond);
      for (const std::int32_t from : {0, 1, 2, 3, 4, 5, 1'000, kMost}) {
        LONGS_EQUAL(0, current_until(here(), bound, from));
      }
    }
  }
}

// For ever, the charge is not counted, nor where nothing is known of it.
TEST(HorizonCurrent, TheLastCountOfTheChargeIsDrawnAndNoneBeyond) {
  HorizonBound deep{Direction::kDischarge, CellVoltage::from_raw(10'000), 1'000};
  for_time(1'000);
  const auto drawn = [&](std::int32_t s, std::int32_t share) {
    cell.s = s;
    horizon.share = share;  // [2^-44 / mA]: of a cell that is so large that it hardly falls
    return current_until(here(), deep, 0);
  };
  LONGS_EQUAL(0, drawn(0, 1));
  LONGS_EQUAL(0, drawn(-1, 1));
  LONGS_EQUAL(1'000, drawn(1, 1));
  LONGS_EQUAL(1'000, drawn(0, 0));
  LONGS_EQUAL(1'000, drawn(-kUnit / 20, 0));
  LONGS_EQUAL(655, drawn(1, 100));  // 2^16 / 100
  LONGS_EQUAL(1'000, drawn(2, 100));
  LONGS_EQUAL(1'000, drawn(1'000, 65'536));
  LONGS_EQUAL(999, drawn(999, 65'536));
  LONGS_EQUAL(999, drawn(1'000, 65'537));
}
