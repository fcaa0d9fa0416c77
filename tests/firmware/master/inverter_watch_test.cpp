// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_watch.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(InverterWatch) {
  Config config{};
  Input in = bench::healthy(config);
  InverterWatchState state{};

  void step(std::int32_t sent_a, std::int32_t driven_a) {
    in.now = in.now + Duration::from_ms(bench::kStepMs);
    in.phase_current = bench::good(Current::from_raw(driven_a * 1000), in.now);
    watch_inverter(config, in, state);
    note_asked(Current::from_raw(sent_a * 1000), Duration::from_ms(bench::kStepMs), state);
  }
  /// Steps until it is told; -1: not within 2 s.
  std::int32_t ms_until_told(std::int32_t sent_a, std::int32_t driven_a) {
    const Instant begin = in.now;
    for (int i = 0; i < 200; ++i) {
      step(sent_a, driven_a);
      if (state.disobeys) return (in.now - begin).ms();
    }
    return -1;
  }
};

TEST(InverterWatch, AnInverterThatFollowsAStepLateIsSound) {
  step(550, 0);
  CHECK_EQUAL(-1, ms_until_told(550, 550));
  for (int i = 0; i < 9; ++i) step(0, 550);  // 90 ms to follow a fall
  CHECK_EQUAL(-1, ms_until_told(0, 0));
}

TEST(InverterWatch, AFootThatChopsAccusesNobody) {
  for (int i = 0; i < 2000; ++i) {
    step(i % 5 < 2 ? 550 : 0, (i + 3) % 5 < 2 ? 550 : 0);  // 20 Hz, followed 20 ms late
    CHECK_FALSE(state.disobeys);
  }
}

TEST(InverterWatch, AnInverterThatFollowsEachFootTwentyTimesLateIsSound) {
  for (int i = 0; i < 2000; ++i) {
    step(i % 40 < 20 ? 550 : 0, (i + 32) % 40 < 20 ? 550 : 0);  // 80 ms late, every 400 ms
    CHECK_FALSE(state.disobeys);
  }
}

TEST(InverterWatch, BrakingThatWasAskedForIsObedience) {
  CHECK_EQUAL(-1, ms_until_told(-300, -300));
}

// MST-041
TEST(InverterWatch, CurrentThatNobodyAsksForIsToldInItsTime) {
  step(550, 550);
  const std::int32_t took = ms_until_told(0, 550);
  CHECK(took > 200);
  CHECK(took <= 310);
  UT_PRINT(StringFromFormat("MST-041: %d ms", took).asCharString());
}

// MST-041
TEST(InverterWatch, CurrentTheWrongWayRoundIsToldToo) {
  CHECK(ms_until_told(0, -60) <= 310);
  CHECK(state.disobeys);
}

TEST(InverterWatch, TheMarginIsKeptToTheMilliampere) {
  in.phase_current = bench::good(Current::from_raw(150'000), in.now);
  CHECK_EQUAL(-1, ms_until_told(100, 150));
  CHECK(ms_until_told(100, 151) > 0);
}

TEST(InverterWatch, CurrentThatIsNotReportedAccusesNobody) {
  for (int i = 0; i < 100; ++i) {
    in.now = in.now + Duration::from_ms(bench::kStepMs);
    in.phase_current = Sample<Current>{Current::from_raw(500'000), in.now, Quality::kInvalid};
    watch_inverter(config, in, state);
    note_asked(Current{}, Duration::from_ms(bench::kStepMs), state);
    CHECK_FALSE(state.disobeys);
  }
}

TEST(InverterWatch, ItEndsWithTheCurrent) {
  CHECK(ms_until_told(0, 550) > 0);
  step(0, 0);
  CHECK_FALSE(state.disobeys);
}

// MST-041
TEST(InverterWatch, WhatWasAskedForIsForgottenAt5500AmperePerSecond) {
  step(550, 0);
  LONGS_EQUAL(550'000, state.asked.raw());
  step(0, 0);
  LONGS_EQUAL(495'000, state.asked.raw());
  step(-520, 0);
  LONGS_EQUAL(520'000, state.asked.raw());
  note_asked(Current{}, Duration{}, state);
  LONGS_EQUAL(520'000, state.asked.raw());
  for (int i = 0; i < 10; ++i) step(0, 0);
  LONGS_EQUAL(0, state.asked.raw());
}
