// SPDX-License-Identifier: Apache-2.0
#include "codec/rx_monitor.hpp"

#include "can_dbc/car.hpp"
#include "codec/seal.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using codec::RxVerdict;

TEST_GROUP(RxMonitor) {
  codec::RxMonitor<can::kBmsRx> monitor;

  static Frame frame(unsigned counter, bool open = false) {
    can::VehicleIo io;
    io.shutdown_closed = !open;
    Frame f;
    can::encode(io, f);
    codec::seal(f, static_cast<std::uint8_t>(counter));
    return f;
  }
  RxVerdict at(std::uint32_t ms, unsigned counter, bool open = false) {
    return monitor.receive(frame(counter, open), Instant::from_ms(ms));
  }
  bool fresh(std::uint32_t ms) { return monitor.fresh(can::VehicleIo::kId, Instant::from_ms(ms)); }
  codec::RxCounts counts() const { return monitor.counts(can::VehicleIo::kId); }
  void synchronise() {
    CHECK(at(0, 0) == RxVerdict::kResynchronising);
    CHECK(at(10, 1) == RxVerdict::kAccepted);
  }
  /// So that it is known when the sender is on time. The last one comes at 200 ms with counter 20.
  void settle() {
    for (unsigned n = 0; n <= 20; ++n) (void)at(10 * n, n);
    CHECK(fresh(200));
  }
};

TEST(RxMonitor, NothingIsFreshBeforeTheFirstFrame) {
  CHECK_FALSE(fresh(0));
  CHECK_FALSE(fresh(1000));
}

TEST(RxMonitor, FirstFrameAloneIsNotBelieved) {
  CHECK(at(0, 0) == RxVerdict::kResynchronising);
  CHECK_FALSE(fresh(0));
  CHECK(at(10, 1) == RxVerdict::kAccepted);
  CHECK(fresh(10));
}

TEST(RxMonitor, StaysFreshUntilTheTimeoutAndNotOneMillisecondLonger) {
  synchronise();
  CHECK(fresh(10 + can::VehicleIo::kTimeoutMs - 1));
  CHECK_FALSE(fresh(10 + can::VehicleIo::kTimeoutMs));
  CHECK_FALSE(fresh(10 + can::VehicleIo::kTimeoutMs + 1));
}

TEST(RxMonitor, TimeBeforeTheLastFrameIsNotFresh) {
  synchronise();
  CHECK_FALSE(fresh(9));
}

// BMS-001
TEST(RxMonitor, EveryCounterStepWithoutAGapInTimeIsForeignButTheNext) {
  for (unsigned start = 0; start < 256; start += 15) {
    for (unsigned step = 0; step < 256; ++step) {
      monitor = {};
      for (unsigned n = 0; n <= 20; ++n) (void)at(10 * n, start + n);
      const RxVerdict found = at(210, start + 20 + step, true);  // other contents: no copy
      CHECK(found == (step == 1 ? RxVerdict::kAccepted : RxVerdict::kForeign));
      LONGS_EQUAL(step == 1 ? 0 : 1, counts().foreign);
      CHECK_EQUAL(step == 1, fresh(200 + can::VehicleIo::kTimeoutMs));
    }
  }
}

// BMS-001
TEST(RxMonitor, FirstFrameBehindAGapThatAgreesIsBelievedWhateverWasLost) {
  for (unsigned lost = 0; lost < 127; ++lost) {
    monitor = {};
    settle();
    CHECK(at(210 + 10 * lost, 21 + lost) == RxVerdict::kAccepted);
    CHECK(fresh(210 + 10 * lost));
    LONGS_EQUAL(0, counts().foreign);
  }
}

TEST(RxMonitor, GapOfHalfARoundSaysNothingAndTwoFramesAreNeeded) {
  settle();
  CHECK(at(200 + 1280, 20 + 128) == RxVerdict::kResynchronising);
  CHECK(at(200 + 1290, 20 + 129) == RxVerdict::kAccepted);
}

TEST(RxMonitor, CountThatRunsAheadOfTimeByOneFrameIsForeignAndOneBehindIsLate) {
  for (unsigned gap = 2; gap < 10; ++gap) {
    monitor = {};
    settle();
    CHECK(at(200 + 10 * gap, 20 + gap + 1, true) == RxVerdict::kForeign);
    monitor = {};
    settle();
    CHECK(at(200 + 10 * gap, 20 + gap - 1, true) == RxVerdict::kAccepted);
  }
}

TEST(RxMonitor, HalfACycleOfHasteIsAllowedAndNoMore) {
  settle();
  CHECK(at(200 + 24, 20 + 3, true) == RxVerdict::kForeign);
  CHECK(at(200 + 25, 20 + 3, true) == RxVerdict::kAccepted);
}

TEST(RxMonitor, LateFrameAndTheOneOnTimeBehindItAreBelievedThoughOneBetweenThemIsLost) {
  settle();
  CHECK(at(220, 21) == RxVerdict::kAccepted);  // 10 ms late
  CHECK(at(230, 23) == RxVerdict::kAccepted);  // 22 is lost, and 23 on time
  CHECK(at(250, 24) == RxVerdict::kAccepted);
  CHECK(at(250, 25) == RxVerdict::kAccepted);  // both at once
  LONGS_EQUAL(0, counts().foreign);
}

TEST(RxMonitor, LatenessIsForgottenAfterSomeSecondsAndSoIsWhatItExcuses) {
  for (const unsigned frames : {19U, 100U, 150U, 579U}) {
    monitor = {};
    settle();
    unsigned n = 21;
    std::uint32_t ms = 230;  // from now on 20 ms late
    for (; n < 21 + frames; ++n, ms += 10) CHECK(at(ms, n) == RxVerdict::kAccepted);
    // 4 us/ms: of 20 ms are 15 left after 1.25 s, which with half a cycle excuse two cycles
    CHECK(at(ms, n + 2, true) == (frames > 125 ? RxVerdict::kForeign : RxVerdict::kAccepted));
  }
}

TEST(RxMonitor, FrameThatComesEarlyIsTheNewMeasureOfLateness) {
  settle();
  CHECK(at(200, 21) == RxVerdict::kAccepted);  // the sender's clock is the faster one
  CHECK(at(210, 22) == RxVerdict::kAccepted);
  CHECK(at(230, 24) == RxVerdict::kAccepted);
  LONGS_EQUAL(0, counts().foreign);
}

TEST(RxMonitor, LateFrameIsRefusedOnlySoonAfterAnotherHadItsCounter) {
  for (const std::uint32_t wait : {0U, 8U}) {
    monitor = {};
    settle();
    CHECK(at(200, 20, true) == RxVerdict::kForeign);
    for (std::uint32_t n = 1; n <= wait; ++n) CHECK(at(200 + 10 * n, 20 + n) == RxVerdict::kAccepted);
    monitor.expire(Instant::from_ms(200 + 10 * wait));
    CHECK(at(220 + 10 * wait, 21 + wait) == (wait == 0 ? RxVerdict::kForeign : RxVerdict::kAccepted));
  }
}

TEST(RxMonitor, ForeignFramesALittleFasterThanTheCycleAreCountedByCycles) {
  settle();
  for (std::uint32_t n = 0; n < 3; ++n) CHECK(at(209 + 9 * n, 100 + n) == RxVerdict::kForeign);
  CHECK_FALSE(monitor.contested());
  CHECK(at(209 + 27, 103) == RxVerdict::kForeign);
  CHECK(monitor.contested());
}

TEST(RxMonitor, ForeignFramesOfLongAgoAreForgottenWhenTheClockComesRound) {
  settle();
  CHECK(at(210, 90) == RxVerdict::kForeign);
  CHECK(at(220, 95) == RxVerdict::kForeign);
  for (std::uint32_t ms = 230; ms < 3'000; ms += 10) monitor.expire(Instant::from_ms(ms));
  CHECK(at(230, 0) == RxVerdict::kResynchronising);  // 49 days later
  CHECK(at(240, 50) == RxVerdict::kForeign);
  CHECK(at(250, 51) == RxVerdict::kAccepted);
  CHECK(at(260, 120) == RxVerdict::kForeign);  // the second of them, and no third
  CHECK_FALSE(monitor.contested());
}

// Its begin is a time that the first foreign frame has not set yet: half a round of the clock away it is not "recent".
TEST(RxMonitor, AForeignFrameIsTheFirstWhateverTheClockSays) {
  for (const std::uint32_t start : {0U, 0x7FFF'FF00U, 0x8000'0000U, 0xFFFF'FF00U}) {
    monitor = {};
    for (unsigned n = 0; n <= 20; ++n) (void)at(start + 10 * n, n);
    for (unsigned n = 1; n <= 3; ++n) {
      CHECK_FALSE(monitor.contested());
      CHECK(at(start + 200 + 10 * n, 100 + n) == RxVerdict::kForeign);
    }
    CHECK(monitor.contested());
  }
}

TEST(RxMonitor, ForeignFramesAreForgottenThoughTheSenderIsForgottenFirst) {
  settle();
  for (std::uint32_t ms = 210; ms <= 4'000; ms += 10) {
    // None of it is next in the count, each within the timeout of the one before, and no three in eight cycles.
    if (ms % 90 == 30 && ms < 1'480) CHECK(at(ms, 220, true) == RxVerdict::kForeign);
    monitor.expire(Instant::from_ms(ms));
  }
  CHECK(at(1'470, 0) == RxVerdict::kResynchronising);  // 49 days later
  CHECK(at(1'480, 50) == RxVerdict::kForeign);
  CHECK(at(1'490, 90) == RxVerdict::kForeign);
  CHECK_FALSE(monitor.contested());
}

TEST(RxMonitor, AMessageThatTheNodeDoesNotReadIsNeverFresh) {
  synchronise();
  CHECK_FALSE(monitor.fresh(can::Pedals::kId, Instant::from_ms(10)));
}

TEST(RxMonitor, LatenessExcusesNoMoreThanEightCycles) {
  for (const unsigned excused : {8U, 9U}) {
    monitor = {};
    settle();
    CHECK(at(200 + 500, 21) == RxVerdict::kAccepted);
    CHECK(at(200 + 500, 21 + excused, true) == (excused == 8 ? RxVerdict::kAccepted : RxVerdict::kForeign));
  }
}

TEST(RxMonitor, WhileTheSenderIsNewFourCyclesAreAllowed) {
  for (const unsigned frames : {2U, 16U, 17U}) {
    for (const unsigned ahead : {4U, 5U}) {
      monitor = {};
      for (unsigned n = 0; n < frames; ++n) (void)at(10 * n, n);
      const bool allowed = frames <= 16 && ahead == 4;
      const RxVerdict found = at(10 * frames, frames + ahead, true);
      CHECK_EQUAL(allowed, found == RxVerdict::kAccepted);
    }
  }
}

TEST(RxMonitor, CellsOfABigPackAreJudgedByTheirSlowerCycle) {
  for (const std::size_t cells : {std::size_t{48}, std::size_t{49}}) {
    monitor = {};
    const auto cell = [&](std::uint32_t ms, unsigned counter) {
      Frame f;
      can::encode(can::CellVoltages{}, f);
      codec::seal(f, static_cast<std::uint8_t>(counter));
      return monitor.receive(f, Instant::from_ms(ms), cells);
    };
    const std::uint32_t cycle = cells > 48 ? 100 : 30;
    for (unsigned n = 0; n <= 20; ++n) (void)cell(cycle * n, n);
    CHECK(cell(20 * cycle + 300, 20 + 300 / cycle) == RxVerdict::kAccepted);
    // 270 ms are nine cycles of 30 ms and not three of 100 ms.
    CHECK(cell(20 * cycle + 570, 20 + 300 / cycle + 9) == (cells > 48 ? RxVerdict::kForeign : RxVerdict::kAccepted));
  }
}

TEST(RxMonitor, StuckSenderNeverBecomesFresh) {
  CHECK(at(0, 7) == RxVerdict::kResynchronising);
  for (std::uint32_t t = 10; t < 1000; t += 10) CHECK(at(t, 7) == RxVerdict::kCopy);
  CHECK_FALSE(fresh(1000));
  LONGS_EQUAL(99, counts().copies);
}

TEST(RxMonitor, SenderThatGetsStuckIsLostAtTheTimeoutAndStaysLost) {
  synchronise();
  for (std::uint32_t t = 20; t < 1000; t += 10) {
    CHECK(at(t, 1) == RxVerdict::kCopy);
    CHECK_EQUAL(t < 110, fresh(t));
  }
  CHECK_FALSE(monitor.contested());
}

TEST(RxMonitor, CopiesChangeNothingAndAreCounted) {
  settle();
  for (unsigned n = 21; n < 300; ++n) {
    CHECK(at(10 * n, n) == RxVerdict::kAccepted);
    CHECK(at(10 * n, n) == RxVerdict::kCopy);
    CHECK(at(10 * n + 5, n) == RxVerdict::kCopy);
  }
  LONGS_EQUAL(2 * 279, counts().copies);
  LONGS_EQUAL(0, counts().foreign);
  CHECK_FALSE(monitor.contested());
}

TEST(RxMonitor, SenderThatStartsAnewAfterASilenceIsBelievedFromItsSecondFrame) {
  settle();
  CHECK(at(200 + can::VehicleIo::kTimeoutMs, 90) == RxVerdict::kResynchronising);
  CHECK(at(210 + can::VehicleIo::kTimeoutMs, 91) == RxVerdict::kAccepted);
  LONGS_EQUAL(0, counts().foreign);
  monitor = {};
  settle();
  CHECK(at(199 + can::VehicleIo::kTimeoutMs, 90) == RxVerdict::kForeign);
}

TEST(RxMonitor, FirstFrameThatNothingFollowsGivesWayToTheNext) {
  CHECK(at(0, 50) == RxVerdict::kResynchronising);
  CHECK(at(10, 90) == RxVerdict::kForeign);
  CHECK(at(20, 91) == RxVerdict::kAccepted);
}

TEST(RxMonitor, FrameOfATimeBeforeTheLastOneIsNotBelieved) {
  settle();
  CHECK(at(190, 21) == RxVerdict::kResynchronising);
  CHECK_FALSE(fresh(200));
}

// BMS-001
TEST(RxMonitor, DamagedShortAndUnknownFramesAreNamedCountedAndRefreshNothing) {
  synchronise();
  Frame bad = frame(2);
  bad.data[0] ^= 1U;
  Frame brief = frame(2);
  brief.dlc = 7;
  Frame unknown = frame(2);
  unknown.id = can::Pedals::kId;  // a message, but none of the BMS
  for (int i = 1; i < 100; ++i) {
    CHECK(monitor.receive(bad, Instant::from_ms(20)) == RxVerdict::kCorrupt);
    CHECK(monitor.receive(brief, Instant::from_ms(20)) == RxVerdict::kWrongLength);
    CHECK(monitor.receive(unknown, Instant::from_ms(20)) == RxVerdict::kUnknownId);
    CHECK(monitor.receive(Frame{can::VehicleIo::kId, 8, {}}, Instant::from_ms(20)) == RxVerdict::kCorrupt);
    LONGS_EQUAL(2 * i, counts().corrupt);
    LONGS_EQUAL(i, counts().wrong_length);
  }
  LONGS_EQUAL(0, counts().foreign + counts().copies);
  LONGS_EQUAL(0, monitor.counts(can::Pedals::kId).corrupt);
  CHECK_FALSE(monitor.contested());
  CHECK(at(20, 2) == RxVerdict::kAccepted);
}

TEST(RxMonitor, CountsStayAtTheirHighest) {
  Frame brief = frame(2);
  brief.dlc = 7;
  for (int i = 0; i < 65'540; ++i) (void)monitor.receive(brief, Instant{});
  LONGS_EQUAL(65'535, counts().wrong_length);
}

TEST(RxMonitor, ExpiredMessageStaysLostWhenTheClockComesRound) {
  synchronise();
  for (std::uint32_t ms = 20; ms <= 10 + 1280; ms += 10) monitor.expire(Instant::from_ms(ms));
  CHECK_FALSE(fresh(10));
  CHECK_FALSE(fresh(20));
}

TEST(RxMonitor, WrapOfTheClockChangesNothing) {
  const std::uint32_t before = 0xFFFFFFFFU - 4;
  (void)at(before - 10, 0);
  CHECK(at(before, 1) == RxVerdict::kAccepted);
  CHECK(fresh(before + 20));  // beyond the wrap
  CHECK(at(before + 20, 3) == RxVerdict::kAccepted);
  CHECK_FALSE(fresh(before + 20 + can::VehicleIo::kTimeoutMs));
}

TEST(RxMonitor, BehindAContradictionHalfACycleOfDelayIsAllowedAndNoMore) {
  for (const std::uint32_t ms : {215U, 216U}) {
    monitor = {};
    settle();
    CHECK(at(200, 20, true) == RxVerdict::kForeign);
    CHECK(at(ms, 21) == (ms == 215 ? RxVerdict::kAccepted : RxVerdict::kForeign));
  }
}

// Only a count that is used twice makes a late frame doubtful, and not for longer than eight cycles.
TEST(RxMonitor, ForeignFramesThatContradictNobodyLeaveLateOnesAlone) {
  settle();
  CHECK(at(205, 90, true) == RxVerdict::kForeign);
  CHECK(at(206, 120, true) == RxVerdict::kForeign);
  CHECK(at(220, 21) == RxVerdict::kAccepted);
  monitor = {};
  settle();
  CHECK(at(200, 20, true) == RxVerdict::kForeign);
  for (unsigned n = 1; n <= 8; ++n) CHECK(at(200 + 10 * n, 20 + n) == RxVerdict::kAccepted);
  CHECK(at(280, 120, true) == RxVerdict::kForeign);
  CHECK(at(300, 29) == RxVerdict::kAccepted);
}

TEST(RxMonitor, LatenessOfBeforeASilenceExcusesNothingBehindIt) {
  settle();
  CHECK(at(280, 21) == RxVerdict::kAccepted);  // 70 ms late
  std::uint32_t ms = 280 + can::VehicleIo::kTimeoutMs;
  unsigned n = 150;
  CHECK(at(ms, n) == RxVerdict::kResynchronising);  // another sender, or the same one anew
  for (int k = 0; k < 20; ++k) CHECK(at(ms += 10, ++n) == RxVerdict::kAccepted);
  CHECK(at(ms + 10, n + 3, true) == RxVerdict::kForeign);
}

TEST(RxMonitor, FrameThatIsRepeatedAfterALongSilenceIsABeginningAndNoCopy) {
  settle();
  for (std::uint32_t ms = 200; ms <= 1'500; ms += 10) monitor.expire(Instant::from_ms(ms));
  CHECK(at(1'510, 20) == RxVerdict::kResynchronising);
  CHECK(at(1'520, 21) == RxVerdict::kAccepted);
  LONGS_EQUAL(0, counts().copies);
}

TEST(RxMonitor, FrameOfATimeBeforeTheLastForeignOneBeginsAnew) {
  settle();
  CHECK(at(205, 90, true) == RxVerdict::kForeign);
  CHECK(at(203, 120) == RxVerdict::kResynchronising);
}
