// SPDX-License-Identifier: Apache-2.0
#include "base/ramp.hpp"

#include <cstdint>
#include <limits>

#include "base/units.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(Ramp) {
  Ramp<Current> ramp{Current::from_raw(500'000)};  // 5'000 units in 10 ms
  std::int32_t after_10_ms(std::int32_t target, std::int32_t before) const {
    return ramp.toward(Current::from_raw(target), Current::from_raw(before), Duration::from_ms(10)).raw();
  }
};

TEST(Ramp, FallsAtOnce) {
  LONGS_EQUAL(0, after_10_ms(0, 400'000));
  LONGS_EQUAL(399'999, after_10_ms(399'999, 400'000));
  LONGS_EQUAL(-7, after_10_ms(-7, 400'000));
}

TEST(Ramp, RisesByItsRateAndStopsAtTheTarget) {
  LONGS_EQUAL(5'000, after_10_ms(400'000, 0));
  LONGS_EQUAL(104'999, after_10_ms(104'999, 100'000));
  LONGS_EQUAL(105'000, after_10_ms(105'000, 100'000));
  LONGS_EQUAL(105'000, after_10_ms(105'001, 100'000));
}

TEST(Ramp, NoTimeIsNoRise) {
  LONGS_EQUAL(3, ramp.toward(Current::from_raw(9), Current::from_raw(3), Duration{}).raw());
  LONGS_EQUAL(2, ramp.toward(Current::from_raw(2), Current::from_raw(3), Duration{}).raw());
}

TEST(Ramp, PartOfAUnitIsNotGiven) {
  ramp.rise_per_s = Current::from_raw(199);
  LONGS_EQUAL(1, after_10_ms(10, 0));
  ramp.rise_per_s = Current::from_raw(99);
  LONGS_EQUAL(0, after_10_ms(10, 0));
}

TEST(Ramp, HighestRateOverTheLongestTimeSaturates) {
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  ramp.rise_per_s = Current::from_raw(kMost);
  const Current target = Current::from_raw(kMost);
  LONGS_EQUAL(kMost, ramp.toward(target, Current{}, Duration::from_ms(kMost)).raw());
  LONGS_EQUAL(kMost, ramp.toward(target, target, Duration::from_ms(kMost)).raw());
}
