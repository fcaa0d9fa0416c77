// SPDX-License-Identifier: Apache-2.0
#include "codec/rx_monitor.hpp"

#include "can_dbc/car.hpp"
#include "codec/seal.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using codec::RxVerdict;

TEST_GROUP(RxMonitor) {
  codec::RxMonitor<can::kBmsRx> monitor;

  static Frame frame(unsigned counter) {
    Frame f;
    can::encode(can::VehicleIo{}, f);
    codec::seal(f, static_cast<std::uint8_t>(counter));
    return f;
  }
  RxVerdict at(std::uint32_t ms, unsigned counter) { return monitor.receive(frame(counter), Instant::from_ms(ms)); }
  bool fresh(std::uint32_t ms) { return monitor.fresh(can::VehicleIo::kId, Instant::from_ms(ms)); }
  void synchronise() {
    CHECK(at(0, 0) == RxVerdict::kResynchronising);
    CHECK(at(10, 1) == RxVerdict::kAccepted);
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
  CHECK(fresh(10 + 49));
  CHECK_FALSE(fresh(10 + 50));
  CHECK_FALSE(fresh(10 + 51));
}

TEST(RxMonitor, TimeBeforeTheLastFrameIsNotFresh) {
  synchronise();
  CHECK_FALSE(fresh(9));
}

TEST(RxMonitor, EveryCounterStepIsJudged) {
  for (unsigned start = 0; start < 16; ++start) {
    for (unsigned step = 0; step < 16; ++step) {
      monitor = {};
      (void)at(0, start);
      CHECK(at(10, start + 1) == RxVerdict::kAccepted);
      const bool believed = step >= 1 && step <= 3;
      CHECK(at(20, start + 1 + step) == (believed ? RxVerdict::kAccepted : RxVerdict::kNotNew));
      CHECK_EQUAL(believed, fresh(65));
    }
  }
}

TEST(RxMonitor, StuckSenderNeverBecomesFresh) {
  for (std::uint32_t t = 0; t < 1000; t += 10) CHECK(at(t, 7) == RxVerdict::kResynchronising);
  CHECK_FALSE(fresh(1000));
}

TEST(RxMonitor, SenderThatGetsStuckIsLostAtTheTimeoutAndStaysLost) {
  synchronise();
  for (std::uint32_t t = 20; t < 1000; t += 10) {
    CHECK(at(t, 1) != RxVerdict::kAccepted);
    CHECK_EQUAL(t < 60, fresh(t));
  }
}

TEST(RxMonitor, AfterATimeoutTwoSuccessiveGoodFramesAreNeeded) {
  synchronise();
  CHECK(at(100, 9) == RxVerdict::kResynchronising);
  CHECK_FALSE(fresh(100));
  CHECK(at(110, 10) == RxVerdict::kAccepted);
  CHECK(fresh(110));
}

TEST(RxMonitor, RestartedSenderIsTakenBackAfterTheTimeout) {
  synchronise();
  CHECK(at(20, 8) == RxVerdict::kNotNew);
  CHECK(at(30, 9) == RxVerdict::kNotNew);
  CHECK(at(60, 12) == RxVerdict::kResynchronising);
  CHECK(at(70, 13) == RxVerdict::kAccepted);
}

TEST(RxMonitor, DamagedShortAndForeignFramesAreNamedAndRefreshNothing) {
  synchronise();
  Frame bad = frame(2);
  bad.data[0] ^= 1U;
  CHECK(monitor.receive(bad, Instant::from_ms(20)) == RxVerdict::kCorrupt);
  Frame brief = frame(2);
  brief.dlc = 7;
  CHECK(monitor.receive(brief, Instant::from_ms(20)) == RxVerdict::kWrongLength);
  Frame foreign = frame(2);
  foreign.id = can::Pedals::kId;  // a message, but none of the BMS
  CHECK(monitor.receive(foreign, Instant::from_ms(20)) == RxVerdict::kUnknownId);
  CHECK(monitor.receive(Frame{can::VehicleIo::kId, 8, {}}, Instant::from_ms(20)) == RxVerdict::kCorrupt);
  CHECK_FALSE(fresh(60));
}

TEST(RxMonitor, ExpiredMessageStaysLostWhenTheClockComesRound) {
  synchronise();
  monitor.expire(Instant::from_ms(60));
  CHECK_FALSE(fresh(10));
  CHECK_FALSE(fresh(20));
}

TEST(RxMonitor, WrapOfTheClockChangesNothing) {
  const std::uint32_t before = 0xFFFFFFFFU - 4;
  (void)at(before - 10, 0);
  CHECK(at(before, 1) == RxVerdict::kAccepted);
  CHECK(fresh(before + 20));  // beyond the wrap
  CHECK(at(before + 20, 2) == RxVerdict::kAccepted);
  CHECK_FALSE(fresh(before + 70));
}
