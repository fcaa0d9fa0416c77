// SPDX-License-Identifier: Apache-2.0
// Two senders of one message, and old frames that are played again: named within eight cycles and not believed.
#include "codec/rx_monitor.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "can_dbc/car.hpp"
#include "codec/seal.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using codec::RxVerdict;

namespace {

constexpr std::uint32_t kStart = 100;  // frames before the trouble begins

}  // namespace

TEST_GROUP(Contested) {
  codec::RxMonitor<can::kMasterRx> monitor;
  std::uint32_t tick = 0;
  std::uint32_t foreign_accepted = 0;

  /// The pedal moves, so that no two frames are equal.
  static Frame pedals(std::uint32_t n, std::int32_t apps1_100uv) {
    can::Pedals m;
    m.apps1_100uv = apps1_100uv;
    m.apps1_ok = true;
    Frame f;
    can::encode(m, f);
    codec::seal(f, static_cast<std::uint8_t>(n));
    return f;
  }
  static Frame own(std::uint32_t n) { return pedals(n, 5'000 + static_cast<std::int32_t>(n % 1000) * 20); }
  RxVerdict receive(const Frame& frame) { return monitor.receive(frame, Instant::from_ms(10 * tick)); }
  void start() {
    monitor = {};
    foreign_accepted = 0;
    for (tick = 0; tick < kStart; ++tick) (void)receive(own(tick));
    CHECK(fresh());
  }
  bool fresh() const { return monitor.fresh(can::Pedals::kId, Instant::from_ms(10 * tick)); }
  /// Milliseconds from the first tick of `trouble` until the message is contested; -1: not within a second.
  template <class Trouble>
  std::int32_t ms_to_contested(Trouble trouble) {
    for (std::uint32_t n = 0; n < 100; ++n, ++tick) {
      trouble(n);
      monitor.expire(Instant::from_ms(10 * tick));
      if (monitor.contested()) return static_cast<std::int32_t>(10 * n);
    }
    return -1;
  }
  void foreign(const Frame& frame) { foreign_accepted += receive(frame) == RxVerdict::kAccepted ? 1 : 0; }
  /// A frame of the last `period` before the trouble, over and over.
  static Frame replayed(std::uint32_t n, std::uint32_t period) { return own(kStart - period + n % period); }
};

// MST-061
TEST(Contested, SecondSenderBesideTheTrueOneIsNamedAtEveryOffset) {
  std::int32_t longest = 0;
  for (const bool first_in_tick : {false, true}) {
    for (std::uint32_t offset = 0; offset < 256; ++offset) {
      start();
      const std::int32_t took = ms_to_contested([&](std::uint32_t) {
        if (first_in_tick) foreign(pedals(tick + offset, 45'000));
        (void)receive(own(tick));
        if (!first_in_tick) foreign(pedals(tick + offset, 45'000));
      });
      CHECK(took >= 0 && took <= 80);
      CHECK_FALSE(fresh());
      CHECK(foreign_accepted <= 3);
      // Only what is next in the count gets through, and the true frame behind it is the first sign.
      if (offset > 1) LONGS_EQUAL(0, foreign_accepted);
      longest = std::max(longest, took);
    }
  }
  std::printf("MST-061: second sender beside the true one, 256 offsets: contested after at most %d ms\n", longest);
}

// MST-061
TEST(Contested, SecondSenderInThePlaceOfTheTrueOneIsNamedAtEveryOffset) {
  std::int32_t longest = 0;
  for (std::uint32_t offset = 1; offset < 256; ++offset) {
    start();
    const std::int32_t took = ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + offset, 45'000)); });
    CHECK(took >= 0 && took <= 80);
    LONGS_EQUAL(0, foreign_accepted);
    longest = std::max(longest, took);
  }
  std::printf("MST-061: second sender in its place, 255 offsets: contested after at most %d ms\n", longest);
}

// MST-061
TEST(Contested, ReplayInThePlaceOfTheTrueSenderIsNamedAtEveryPeriod) {
  std::int32_t longest = 0;
  for (std::uint32_t period = 2; period <= 64; ++period) {
    start();
    const std::int32_t took = ms_to_contested([&](std::uint32_t n) { foreign(replayed(n, period)); });
    CHECK(took >= 0 && took <= 80);
    LONGS_EQUAL(0, foreign_accepted);
    longest = std::max(longest, took);
  }
  std::printf("MST-061: replay in its place, periods 2 to 64: contested after at most %d ms\n", longest);
}

// MST-061: of a single frame there are only copies, and its age tells.
TEST(Contested, ReplayOfTheLastFrameAgesLikeSilence) {
  start();
  const std::int32_t took = ms_to_contested([&](std::uint32_t n) {
    foreign(replayed(n, 1));
    CHECK_EQUAL(10 * (n + 1) < can::Pedals::kTimeoutMs, fresh());
  });
  LONGS_EQUAL(-1, took);
  LONGS_EQUAL(0, foreign_accepted);
}

// MST-061
TEST(Contested, ReplayBesideTheTrueSenderIsNamedAtEveryPeriod) {
  std::int32_t longest = 0;
  for (std::uint32_t period = 1; period <= 64; ++period) {
    start();
    const std::int32_t took = ms_to_contested([&](std::uint32_t n) {
      (void)receive(own(tick));
      foreign(replayed(n, period));
    });
    CHECK(took >= 0 && took <= 80);
    LONGS_EQUAL(0, foreign_accepted);
    longest = std::max(longest, took);
  }
  std::printf("MST-061: replay beside the true sender, periods 1 to 64: contested after at most %d ms\n", longest);
}

// MST-061: and from then on for ever.
TEST(Contested, ReplayIsNeverBelievedAgainUnlessItIsOfAWholeRound) {
  for (std::uint32_t period = 1; period <= 300; ++period) {
    monitor = {};
    std::uint32_t accepted = 0;
    for (tick = 0; tick < 400; ++tick) (void)receive(own(tick));
    for (std::uint32_t n = 0; n < 2000; ++n, ++tick) {
      accepted += receive(own(400 - period + n % period)) == RxVerdict::kAccepted ? 1 : 0;
      monitor.expire(Instant::from_ms(10 * tick));
    }
    if (period < 256) LONGS_EQUAL(0, accepted);
    if (period > 256) CHECK(accepted < 2000 / 256 * (period - 256));  // of each turn what is beyond a whole round
    if (period == 256) CHECK(accepted > 1900);  // documented: nothing tells it from the true sender
  }
}

TEST(Contested, MessageIsBelievedAgainAfterOneWholeRoundWithoutAJump) {
  start();
  CHECK(ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + 7, 45'000)); }) >= 0);
  ++tick;
  (void)receive(own(tick));
  for (std::uint32_t n = 1; n < 256; ++n) {
    ++tick;
    CHECK(receive(own(tick)) == RxVerdict::kResynchronising);
    CHECK(monitor.contested());
    CHECK_FALSE(fresh());
  }
  ++tick;
  CHECK(receive(own(tick)) == RxVerdict::kAccepted);
  CHECK_FALSE(monitor.contested());
  CHECK(fresh());
  // And nothing is left of what was: one more jump is none again and again.
  CHECK(receive(pedals(tick + 7, 45'000)) == RxVerdict::kForeign);
  CHECK_FALSE(monitor.contested());
}

TEST(Contested, JumpWithinTheRoundBeginsItAnewAndLostFramesDoNot) {
  start();
  CHECK(ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + 7, 45'000)); }) >= 0);
  for (int n = 0; n < 200; ++n) (void)receive(own(++tick));
  (void)receive(pedals(tick + 7, 45'000));
  for (int n = 0; n < 200; ++n) (void)receive(own(++tick));
  CHECK(monitor.contested());
  ++tick;  // one frame is lost
  for (int n = 0; n < 56; ++n) (void)receive(own(++tick));
  CHECK_FALSE(monitor.contested());
}

TEST(Contested, SilenceDoesNotEndIt) {
  for (const std::uint32_t silent : {5U, 50U, 500U, 5000U}) {
    start();
    CHECK(ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + 7, 45'000)); }) >= 0);
    for (std::uint32_t n = 0; n < silent; ++n) monitor.expire(Instant::from_ms(10 * ++tick));
    for (std::uint32_t n = 0; n < 200; ++n) CHECK(receive(own(++tick)) != RxVerdict::kAccepted);
    CHECK(monitor.contested());
  }
}

// Noise that happens to fit its CRC is no second sender: one frame in 256 of what a babbling node sends.
TEST(Contested, TwoForeignFramesInEightCyclesAreNotAgainAndAgain) {
  for (std::uint32_t apart = 1; apart < 8; ++apart) {
    start();
    for (std::uint32_t n = 0; n < 200; ++n, ++tick) {
      CHECK(receive(own(tick)) == RxVerdict::kAccepted);
      if (n % 9 == 0 || n % 9 == apart) CHECK(receive(pedals(tick + 100, 45'000)) == RxVerdict::kForeign);
      CHECK_FALSE(monitor.contested());
    }
  }
}

TEST(Contested, ThreeForeignFramesWithinEightCyclesAreAndInNineAreNot) {
  for (const std::uint32_t last : {7U, 8U}) {
    start();
    for (std::uint32_t n = 0; n < 10; ++n, ++tick) {
      (void)receive(own(tick));
      if (n == 0 || n == 3 || n == last) (void)receive(pedals(tick + 100, 45'000));
    }
    CHECK_EQUAL(last == 7, monitor.contested());
  }
}

// Of a message that is slower than a tick two are enough.
TEST(Contested, TwoForeignFramesOfASlowMessageWithinEightCyclesAreAndInNineAreNot) {
  for (const std::uint32_t last : {7U, 8U}) {
    monitor = {};
    const auto receive_at = [&](std::uint32_t n, std::uint32_t counter) {
      can::MotorTemperatures m;
      m.motor_dc = static_cast<std::int32_t>(counter);
      m.motor_ok = true;
      Frame f;
      can::encode(m, f);
      codec::seal(f, static_cast<std::uint8_t>(counter));
      return monitor.receive(f, Instant::from_ms(100 * n));
    };
    for (std::uint32_t n = 0; n < 40; ++n) {
      (void)receive_at(n, n);
      if (n == 20 || n == 20 + last) CHECK(receive_at(n, n + 100) == RxVerdict::kForeign);
    }
    CHECK_EQUAL(last == 7, monitor.contested());
  }
}

TEST(Contested, ManyForeignFramesInOneCycleAreOneSign) {
  start();
  (void)receive(own(tick));
  for (std::uint32_t n = 0; n < 50; ++n) CHECK(receive(pedals(tick + 100 + n, 45'000)) == RxVerdict::kForeign);
  CHECK_FALSE(monitor.contested());
  LONGS_EQUAL(50, monitor.counts(can::Pedals::kId).foreign);
}

TEST(Contested, TwoSendersFromPowerOnAreNamedToo) {
  const std::int32_t took = ms_to_contested([&](std::uint32_t) {
    (void)receive(own(tick));
    foreign(pedals(tick + 100, 45'000));
  });
  CHECK(took >= 0 && took <= 80);
  LONGS_EQUAL(0, foreign_accepted);
}

TEST(Contested, OneMessageIsContestedAndTheOthersAreNot) {
  start();
  Frame io;
  can::encode(can::VehicleIo{}, io);
  CHECK(ms_to_contested([&](std::uint32_t) {
          foreign(pedals(tick + 7, 45'000));
          codec::seal(io, static_cast<std::uint8_t>(tick));
          (void)receive(io);
        }) >= 0);
  CHECK(monitor.fresh(can::VehicleIo::kId, Instant::from_ms(10 * tick)));
  CHECK_FALSE(monitor.fresh(can::Pedals::kId, Instant::from_ms(10 * tick)));
}

// MST-061: a round of before is not credited.
TEST(Contested, WhoIsContestedAgainNeedsAWholeRoundAgain) {
  start();
  for (int times = 0; times < 2; ++times) {
    const std::uint32_t offset = times == 0 ? 7 : 90;
    CHECK(ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + offset, 45'000)); }) >= 0);
    int frames = 0;  // of the one that has taken its place
    RxVerdict found = RxVerdict::kForeign;
    while (found != RxVerdict::kAccepted && frames < 1'000) {
      ++tick;
      ++frames;
      found = receive(pedals(tick + offset, 5'000 + static_cast<std::int32_t>(tick % 1000) * 20));
      CHECK_EQUAL(frames < 256, monitor.contested());
    }
    LONGS_EQUAL(256, frames);
  }
}

TEST(Contested, ForeignFramesAreNamedAndCountedWhileItIsContested) {
  start();
  CHECK(ms_to_contested([&](std::uint32_t) { foreign(pedals(tick + 7, 45'000)); }) >= 0);
  const unsigned before = monitor.counts(can::Pedals::kId).foreign;
  for (unsigned n = 1; n <= 5; ++n) {
    ++tick;
    CHECK(receive(pedals(tick + 50 * n, 45'000)) == RxVerdict::kForeign);
    LONGS_EQUAL(before + n, monitor.counts(can::Pedals::kId).foreign);
  }
}
