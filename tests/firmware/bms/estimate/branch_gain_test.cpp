// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/branch_gain.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "CppUTest/TestHarness.h"

using namespace voltlap::bms;

TEST_GROUP(BranchGain) {
  std::mt19937_64 random{3};
  /// Of a time constant between the shortest and the longest that config_check lets in.
  std::int32_t drawn_rate() {
    const double ms = std::exp(std::uniform_real_distribution(std::log(500.0), std::log(1e8))(random));
    return static_cast<std::int32_t>(std::ldexp(1.0, kRateBits) / ms);
  }
  static double x_of(std::int32_t rate, std::int32_t ms) { return std::ldexp(rate, -kRateBits) * ms; }
};

// BMS-081
TEST(BranchGain, OfAStepIsItsTwinInDoublePrecisionAndStopsAtFortyNineHundredths) {
  int held = 0;
  for (int draw = 0; draw < 100'000; ++draw) {
    const std::int32_t rate = drawn_rate(), ms = 1 + static_cast<std::int32_t>(random() % 1'000);
    const double x = x_of(rate, ms);
    held += x > 0.49 ? 1 : 0;
    const double held_x = std::min(x, 0.49), rest = std::pow(held_x, 5.0) / 120.0;  // of the series, to x^4
    DOUBLES_EQUAL(-std::expm1(-held_x), std::ldexp(gain_of(rate, ms), -32), rest + 1e-8);
  }
  CHECK(held > 1'000);
}

// BMS-045
TEST(BranchGain, OfAnyTimeIsItsTwinInDoublePrecisionToWhereNothingIsLeft) {
  int over = 0;
  for (int draw = 0; draw < 100'000; ++draw) {
    const std::int32_t rate = drawn_rate(), ms = 1 + static_cast<std::int32_t>(random() % 30'000);
    const double x = x_of(rate, ms);
    over += x >= 22.0 ? 1 : 0;
    DOUBLES_EQUAL(-std::expm1(-x), std::ldexp(long_gain_of(rate, ms), -kLongGainBits), 3e-4);
  }
  CHECK(over > 500);
  LONGS_EQUAL(1 << kLongGainBits, long_gain_of((std::int64_t{1} << kRateBits) / 500, 30'000));
}

// BMS-081
TEST(BranchGain, ATimeThatIsShorterThanAQuarterOfTheTablesCountsAsThat) {
  for (int draw = 0; draw < 100'000; ++draw) {
    const std::int32_t rate = drawn_rate();
    const double factor = std::uniform_real_distribution(0.0, 7.9)(random);
    const double expected = rate / std::max(factor, 0.26);
    const auto raw = static_cast<std::int32_t>(std::ldexp(factor, kUnitBits));
    DOUBLES_EQUAL(expected, slowed(rate, raw), 4e-4 * expected + 1.0);
  }
}
