// SPDX-License-Identifier: Apache-2.0
#include "io/play/lateness.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Lateness) { Lateness lateness; };

TEST(Lateness, QuantilesAreOfTheFramesThatWereCounted) {
  for (int k = 1; k <= 1000; ++k) lateness.add(k * 1000);  // 1 to 1000 us
  DOUBLES_EQUAL(0.5, lateness.quantile_ms(0.5), 1e-9);
  DOUBLES_EQUAL(0.999, lateness.quantile_ms(0.999), 1e-9);
  DOUBLES_EQUAL(1.0, lateness.worst_ms(), 1e-9);
  LONGS_EQUAL(1000, lateness.count());
}

TEST(Lateness, ASpacingIsOffWhenItsEndsAreNotAsLateAsEachOther) {
  for (const std::int64_t late_us : {0, 5000, 5000, 5500, 0}) lateness.add(1000 * late_us);
  LONGS_EQUAL(2, lateness.spacings_off());
  DOUBLES_EQUAL(5.5, lateness.worst_ms(), 1e-9);
}

TEST(Lateness, BeyondATenthOfASecondTheWorstIsSaid) {
  lateness.add(3'000'000'000);
  DOUBLES_EQUAL(3000.0, lateness.quantile_ms(0.5), 1e-9);
}

TEST(Lateness, AFrameBeforeItsTimeIsNotLate) {
  lateness.add(-20'000'000);
  DOUBLES_EQUAL(0.0, lateness.quantile_ms(1.0), 1e-9);
  DOUBLES_EQUAL(0.0, lateness.worst_ms(), 1e-9);
}
