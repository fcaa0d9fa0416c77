// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/can_timing.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port::stm32;

TEST_GROUP(CanTiming) {
  static std::uint32_t quanta(const CanTiming& t) { return 1U + t.segment1 + t.segment2; }
  static void check(std::uint32_t clock_hz, std::uint32_t bit_rate, CanTimingLimits limits) {
    const CanTiming t = can_timing(clock_hz, bit_rate, limits);
    CHECK(t.prescaler != 0);
    UNSIGNED_LONGS_EQUAL(clock_hz, bit_rate * t.prescaler * quanta(t));
    const std::uint32_t point = (1U + t.segment1) * 1000 / quanta(t);
    CHECK(point >= 825 && point <= 925);
    CHECK(t.prescaler <= limits.prescaler_max && t.segment1 >= limits.segment1_min);
    CHECK(t.segment1 <= limits.segment1_max && t.segment2 >= limits.segment2_min && t.segment2 <= limits.segment2_max);
    CHECK(t.jump >= 1 && t.jump <= t.segment2 && t.jump <= limits.jump_max);
  }
};

TEST(CanTiming, TheUsualClocksMakeTheUsualRatesExactly) {
  for (const std::uint32_t rate : {125'000U, 250'000U, 500'000U, 1'000'000U}) {
    for (const std::uint32_t clock : {8'000'000U, 16'000'000U, 24'000'000U, 36'000'000U, 42'000'000U, 48'000'000U}) {
      if (clock == 42'000'000U && rate == 1'000'000U) continue;  // 21 quanta: held by the next test
      check(clock, rate, kBxCanLimits);
    }
    for (const std::uint32_t clock : {40'000'000U, 80'000'000U, 160'000'000U, 170'000'000U}) {
      check(clock, rate, kFdCanLimits);
    }
  }
}

TEST(CanTiming, AnAPB1Of42MHzMakes500kbitWithItsSamplePointAt857permille) {
  const CanTiming t = can_timing(42'000'000, 500'000, kBxCanLimits);
  UNSIGNED_LONGS_EQUAL(6, t.prescaler);  // 14 quanta, the sample after 12: 857; 21 quanta would want a segment of 17
  UNSIGNED_LONGS_EQUAL(11, t.segment1);
  UNSIGNED_LONGS_EQUAL(2, t.segment2);
}

TEST(CanTiming, WhatTheClockCannotMakeIsNone) {
  UNSIGNED_LONGS_EQUAL(0, can_timing(42'000'000, 800'000, kBxCanLimits).prescaler);   // 52.5 clocks a bit
  UNSIGNED_LONGS_EQUAL(0, can_timing(4'000'000, 1'000'000, kBxCanLimits).prescaler);  // 4 quanta
  UNSIGNED_LONGS_EQUAL(0, can_timing(42'000'000, 0, kBxCanLimits).prescaler);
  UNSIGNED_LONGS_EQUAL(0, can_timing(0, 500'000, kBxCanLimits).prescaler);
  UNSIGNED_LONGS_EQUAL(0, can_timing(168'000'000, 1'000, kBxCanLimits).prescaler);  // beyond the prescaler
  UNSIGNED_LONGS_EQUAL(0, can_timing(8'000'000, 1'000'000, kBxCanLimits, 150).prescaler);
}

TEST(CanTiming, EveryClockThatIsFoundIsExactAndInsideTheRegisters) {
  std::uint32_t made = 0;
  for (std::uint32_t clock = 1'000'000; clock <= 170'000'000; clock += 250'000) {
    if (can_timing(clock, 500'000, kBxCanLimits).prescaler == 0) continue;
    check(clock, 500'000, kBxCanLimits);
    ++made;
  }
  CHECK(made > 100);
}
