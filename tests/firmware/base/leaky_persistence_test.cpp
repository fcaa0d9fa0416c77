// SPDX-License-Identifier: Apache-2.0
#include "base/leaky_persistence.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(LeakyPersistence) {
  LeakyPersistence p;
  bool at(std::uint32_t ms, bool condition = true) {
    return p.held(condition, Instant::from_ms(ms), Duration::from_ms(100));
  }
  /// Steps of 10 ms, `on` of every `period` with the condition; ms until it is held, -1 for never within 5 s.
  int ms_until_held(int on, int period) {
    for (int step = 0; step < 500; ++step) {
      if (at(static_cast<std::uint32_t>(10 * step), step % period < on)) return 10 * step;
    }
    return -1;
  }
};

TEST(LeakyPersistence, WithoutAPauseItHoldsFromItsTimeOnAndNotOneMillisecondEarlier) {
  CHECK_FALSE(at(1'000));
  CHECK_FALSE(at(1'099));
  CHECK(at(1'100));
  CHECK(at(5'000));
  CHECK_FALSE(at(5'001, false));
}

TEST(LeakyPersistence, APauseTakesBackAQuarterOfItself) {
  CHECK_FALSE(at(0));
  CHECK_FALSE(at(80));
  CHECK_FALSE(at(120, false));  // 40 ms take back 10 of 80
  CHECK_FALSE(at(130));
  CHECK_FALSE(at(159));
  CHECK(at(160));  // 70 and 30
}

TEST(LeakyPersistence, WhatIsThereForMoreThanAFifthOfTheTimeIsFound) {
  CHECK(ms_until_held(3, 6) > 100);
  p = {};
  CHECK_EQUAL(-1, ms_until_held(1, 6));  // a single step is over when it is seen
  p = {};
  CHECK(ms_until_held(2, 4) > 100);
}

TEST(LeakyPersistence, WrapOfTimeChangesNothing) {
  CHECK_FALSE(at(0xFFFFFFF0U));
  CHECK_FALSE(at(83));
  CHECK(at(84));
}

TEST(LeakyPersistence, TimeThatRunsBackCountsNothing) {
  CHECK_FALSE(at(1'000));
  CHECK_FALSE(at(900));
  CHECK_FALSE(at(999));
  CHECK(at(1'000));
}
