// SPDX-License-Identifier: Apache-2.0
#include "base/persistence.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(Persistence) {
  Persistence p;
  bool at(std::uint32_t ms, bool condition = true) {
    return p.held(condition, Instant::from_ms(ms), Duration::from_ms(100));
  }
};

TEST(Persistence, HoldsFromItsTimeOnAndNotOneMillisecondEarlier) {
  CHECK_FALSE(at(1'000));
  CHECK_FALSE(at(1'099));
  CHECK(at(1'100));
  CHECK(at(5'000));
}

TEST(Persistence, BreakBeginsTheTimeAnew) {
  CHECK_FALSE(at(0));
  CHECK_FALSE(at(90, false));
  CHECK_FALSE(at(100));
  CHECK_FALSE(at(199));
  CHECK(at(200));
  CHECK_FALSE(at(201, false));
}

TEST(Persistence, WrapOfTimeChangesNothing) {
  CHECK_FALSE(at(0xFFFFFFF0U));
  CHECK_FALSE(at(83));
  CHECK(at(84));
}

TEST(Persistence, ConditionHeldForMoreThanHalfTheClockIsNotForgotten) {
  CHECK_FALSE(at(0));
  CHECK(at(100));
  CHECK(at(0x80000001U));
}
