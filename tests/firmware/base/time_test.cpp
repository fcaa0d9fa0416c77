// SPDX-License-Identifier: Apache-2.0
#include "base/time.hpp"

#include "base/sample.hpp"
#include "base/units.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(Time) {};

TEST(Time, DifferencesAreRightAcrossTheWrap) {
  const Instant before = Instant::from_ms(0xFFFFFFF0U);
  const Instant after = before + Duration::from_ms(32);
  LONGS_EQUAL(16, after.ms());
  LONGS_EQUAL(32, (after - before).ms());
  LONGS_EQUAL(-32, (before - after).ms());
}

TEST(Time, AllZeroSampleWasNeverReceived) {
  const Sample<Current> sample{};
  CHECK(sample.quality == Quality::kNone);
  CHECK_FALSE(sample.good());
}
