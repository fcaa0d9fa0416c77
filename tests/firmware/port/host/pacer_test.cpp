// SPDX-License-Identifier: Apache-2.0
// Lower bounds only: a loaded machine may always be later.
#include "port/host/pacer.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port;

TEST_GROUP(Pacer) {
  WallClock clock;
};

TEST(Pacer, FirstStepIsDueAtOnceAndTheOthersOnePeriodApart) {
  Pacer pacer(20'000, Lag::kCatchUp);
  pacer.wait();
  for (int i = 0; i < 5; ++i) pacer.wait();
  CHECK(clock.now_us() >= 100'000);
}

TEST(Pacer, LateStepsAreCountedWithTheWorst) {
  Pacer pacer(10'000, Lag::kCatchUp);
  pacer.wait();
  clock.sleep_until_us(clock.now_us() + 60'000);
  pacer.wait();
  CHECK(pacer.late_steps() >= 1);
  CHECK(pacer.worst_us() >= 45'000);
}

TEST(Pacer, CatchesUpWhatItMissed) {
  Pacer pacer(10'000, Lag::kCatchUp);
  pacer.wait();
  clock.sleep_until_us(clock.now_us() + 50'000);
  pacer.wait();
  CHECK(pacer.ahead_us() < 0);
}

TEST(Pacer, ABoundForgetsWhatItMissed) {
  Pacer pacer(20'000, Lag::kForget);
  pacer.wait();
  clock.sleep_until_us(clock.now_us() + 100'000);
  const std::int64_t begin = clock.now_us();
  pacer.wait();
  pacer.wait();
  CHECK(clock.now_us() - begin >= 20'000);
  LONGS_EQUAL(0, pacer.late_steps());
}

TEST(Pacer, AfterALongSleepOfTheMachineItBeginsAnew) {
  Pacer pacer(1'000, Lag::kCatchUp);
  pacer.wait();
  clock.sleep_until_us(clock.now_us() + 1'100'000);
  pacer.wait();
  pacer.wait();
  CHECK(pacer.ahead_us() > -1'000'000);  // it would be 1.1 s behind
}
