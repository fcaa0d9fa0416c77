// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/lsi_clock.hpp"

#include "fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port::stm32;

namespace {

/// RM0090 18.3.5: a counter of the timer's clock; each edge of the LSI copies it and raises the flag, and the flag of
/// an overwritten capture where the one before was not read.
class FakeTimer final : public test::Model {
 public:
  explicit FakeTimer(std::uint8_t channel, std::uint32_t mask) : channel_(channel), mask_(mask) {}

  TimerRegisters block{};
  double timer_hz = 84e6, core_hz = 168e6, lsi_hz = 32'000;
  bool stands = false;
  std::uint32_t lsi_select = 0;  ///< in the option register: the channel hears the LSI
  std::uint64_t reads = 0;
  int long_interrupt_in = -1;  ///< reads until one that lasts three periods

  std::uint32_t read(std::size_t offset) override {
    ++reads;
    pass(8.0 / core_hz);
    if (long_interrupt_in >= 0 && long_interrupt_in-- == 0) pass(3.0 / lsi_hz);
    if (offset == 0x10) return flags_;
    if (offset == 0x34 + 4U * (channel_ - 1U)) {
      flags_ &= ~(1U << channel_);
      return captured_;
    }
    return words_[offset / 4];
  }
  void write(std::size_t offset, std::uint32_t value) override {
    if (offset == 0x10) {
      flags_ &= value;
    } else {
      words_[offset / 4] = value;
    }
  }
  [[nodiscard]] bool captures() const {
    const unsigned index = channel_ - 1U;
    const bool input = (words_[6 + index / 2] >> (index % 2 * 8) & 3U) == 1U;
    const bool counts = (words_[8] >> (4 * index) & 1U) != 0 && (words_[0] & 1U) != 0;
    return input && counts && words_[20] == lsi_select && !stands;
  }

 private:
  void pass(double seconds) {
    for (; seconds > 0.0; seconds -= kStep_s) {
      const double step = seconds < kStep_s ? seconds : kStep_s;
      counter_ += timer_hz * step;
      phase_ += lsi_hz * step;
      if (phase_ < 1.0) continue;
      phase_ -= 1.0;
      if (!captures()) continue;
      if ((flags_ >> channel_ & 1U) != 0) flags_ |= 1U << (8 + channel_);
      flags_ |= 1U << channel_;
      const double at_edge = counter_ - timer_hz * phase_ / lsi_hz;
      captured_ = static_cast<std::uint32_t>(static_cast<std::uint64_t>(at_edge)) & mask_;
    }
  }

  static constexpr double kStep_s = 1e-6;
  std::uint8_t channel_;
  std::uint32_t mask_, words_[24] = {}, flags_ = 0, captured_ = 0;
  double counter_ = 0.0, phase_ = 0.0;
};

struct Part {
  std::uint8_t channel;
  std::uint32_t mask;
  std::uint32_t timer_hz, core_hz;
  LsiRange lsi;
};
constexpr Part kF4{4, 0xFFFF'FFFFU, 84'000'000, 168'000'000, kLsiStm32f4};
constexpr Part kG4{1, 0xFFFFU, 144'000'000, 144'000'000, kLsiStm32g4};

constexpr std::uint32_t kSelect = 1U << 6;

/// A part whose clock is `c` times what it should be, with an LSI of this frequency.
struct Bench {
  FakeTimer fake;
  test::Attached attached{&fake.block, sizeof fake.block, fake};
  Register csr;
  LsiClock clock;

  explicit Bench(const Part& part, double c = 1.0, double lsi_hz = 32'000)
      : fake(part.channel, part.mask), clock(fake.block, {part.channel, part.mask, part.timer_hz, part.lsi}) {
    fake.timer_hz = c * part.timer_hz;
    fake.core_hz = c * part.core_hz;
    fake.lsi_hz = lsi_hz;
    csr.write(2);  // LSIRDY
    fake.lsi_select = kSelect;
    clock.start(csr, fake.block.option, kSelect);
  }
  /// Ticks until it is told; 0: never within 300.
  int ticks_until_lost() {
    for (int tick = 1; tick <= 300; ++tick) {
      if (!clock.agrees()) return tick;
    }
    return 0;
  }
};

constexpr int kFirstTold = static_cast<int>((LsiClock::kLooksMost - 1) * LsiClock::kTicksPerLook + 1);

}  // namespace

TEST_GROUP(LsiClock){};

TEST(LsiClock, AClockThatIsRightAgreesWithEveryLsiOfTheDatasheet) {
  for (const Part& part : {kF4, kG4}) {
    const double step = (part.lsi.fastest_hz - part.lsi.slowest_hz) / 40.0;
    for (int i = 0; i <= 40; ++i) {
      Bench bench(part, 1.0, part.lsi.slowest_hz + i * step);
      LONGS_EQUAL(0, bench.ticks_until_lost());
      CHECK((bench.csr.read() & 1U) != 0);
    }
  }
}

// DIA-005
TEST(LsiClock, AClockBeyondTheRatioOfTheDatasheetIsToldInTheThirdLookWithEveryLsi) {
  for (const Part& part : {kF4, kG4}) {
    const double ratio = static_cast<double>(part.lsi.fastest_hz) / part.lsi.slowest_hz;
    for (const double c : {1.01 * ratio, 3.125, 6.0, 0.99 / ratio, 0.25, 16.0 / 168.0}) {
      for (const double lsi : {1.0 * part.lsi.slowest_hz, 32'000.0, 1.0 * part.lsi.fastest_hz}) {
        Bench bench(part, c, lsi);
        LONGS_EQUAL(kFirstTold, bench.ticks_until_lost());
        CHECK(!bench.clock.agrees());
      }
    }
  }
}

TEST(LsiClock, WithATypicalLsiTheBoundIsAsDocumented) {
  LONGS_EQUAL(0, Bench(kF4, 1.86).ticks_until_lost());
  LONGS_EQUAL(kFirstTold, Bench(kF4, 1.90).ticks_until_lost());
  LONGS_EQUAL(0, Bench(kF4, 0.69).ticks_until_lost());
  LONGS_EQUAL(kFirstTold, Bench(kF4, 0.67).ticks_until_lost());
}

TEST(LsiClock, AnLsiThatStandsOrIsNotConnectedIsToldAndNoWaitIsEndless) {
  Bench stands(kF4), elsewhere(kF4);
  stands.fake.stands = true;
  elsewhere.fake.lsi_select = 0;
  LONGS_EQUAL(kFirstTold, stands.ticks_until_lost());
  LONGS_EQUAL(kFirstTold, elsewhere.ticks_until_lost());
  CHECK(stands.fake.reads < 3 * 2'600);
  const std::uint64_t before = stands.fake.reads;
  for (int i = 0; i < 100; ++i) CHECK(!stands.clock.agrees());
  CHECK(stands.fake.reads == before);  // for good, and nothing more to wait for
}

TEST(LsiClock, AnInterruptInALookIsNoFaultOfTheClockAndOnlyManyAreTold) {
  Bench now_and_then(kF4), always(kF4);
  for (int tick = 0; tick < 400; ++tick) {
    if (tick % 20 == 0) now_and_then.fake.long_interrupt_in = 5 * tick / 20;
    CHECK(now_and_then.clock.agrees());
  }
  int lost_at = 0;
  for (int tick = 1; tick <= 300 && lost_at == 0; ++tick) {
    always.fake.long_interrupt_in = 3;
    if (!always.clock.agrees()) lost_at = tick;
  }
  LONGS_EQUAL((LsiClock::kTornMost - 1) * LsiClock::kTicksPerLook + 1, lost_at);
}

TEST(LsiClock, ALookTakesTwoPeriodsAtMostThreeAndNineTicksOfTenTakeNothing) {
  Bench slowest(kF4, 1.0, 17'000);
  for (int tick = 0; tick < 100; ++tick) {
    const std::uint64_t before = slowest.fake.reads;
    CHECK(slowest.clock.agrees());
    const double took_s = static_cast<double>(slowest.fake.reads - before) * 8.0 / 168e6;
    CHECK(tick % 10 == 0 ? took_s < 120e-6 : took_s <= 0.0);
  }
}
