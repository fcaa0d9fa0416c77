// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/watchdog.hpp"

#include "fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port::stm32;

namespace {

/// RM0090 chapter 21: PR and RLR are taken only behind the key, while the oscillator runs and SR is clear.
class FakeIwdg final : public test::Model {
 public:
  IwdgRegisters block{};
  bool oscillates = true;
  bool running = false;
  std::uint32_t pr = 0, rlr = 0xFFF, reloads = 0;

  std::uint32_t read(std::size_t offset) override {
    switch (offset) {
      case 0x04: return pr;
      case 0x08: return rlr;
      case 0x0C: return busy_ > 0 && oscillates && --busy_ == 0 ? 0U : busy_ > 0 ? 3U : 0U;
      default: return 0;  // KR reads as 0
    }
  }
  void write(std::size_t offset, std::uint32_t value) override {
    if (offset == 0x00) {
      open_ = value == 0x5555;
      if (value == 0xCCCC) running = true;
      if (value == 0xAAAA) ++reloads;
      return;
    }
    if (!open_) return;
    if (offset == 0x04) pr = value & 7U;
    if (offset == 0x08) rlr = value & 0xFFFU;
    busy_ = 5;
  }

 private:
  bool open_ = false;
  int busy_ = 0;
};

}  // namespace

TEST_GROUP(Iwdg) {
  FakeIwdg fake;
  test::Attached attached{&fake.block, sizeof fake.block, fake};
  Register rcc_csr;
  Iwdg dog{fake.block, rcc_csr, 1U << 24, kLsiStm32f4};
};

// DIA-004
TEST(Iwdg, ItBitesAtTheTimeoutAtTheLatestWithTheSlowestOscillatorAndNotBeforeATickWithTheFastest) {
  CHECK(dog.start(Duration::from_ms(100)));
  CHECK(fake.running);
  const std::uint32_t lsi_counts = (fake.rlr + 1) * (4U << fake.pr);
  CHECK(lsi_counts * 1000ULL <= 100ULL * kLsiStm32f4.slowest_hz);
  CHECK(lsi_counts * 1000ULL > 95ULL * kLsiStm32f4.slowest_hz);
  const std::int32_t earliest = dog.earliest_bite(Duration::from_ms(100)).ms();
  CHECK(earliest <= static_cast<std::int32_t>(lsi_counts * 1000ULL / kLsiStm32f4.fastest_hz));
  CHECK(earliest >= 30);
}

TEST(Iwdg, EveryTimeoutFromOneMillisecondOnIsMetOrRefused) {
  std::int32_t longest = 0;
  for (std::int32_t ms = 1; ms < 80'000; ms += ms < 200 ? 1 : 997) {
    if (!dog.start(Duration::from_ms(ms))) continue;
    longest = ms;
    const std::uint64_t counts = (fake.rlr + 1ULL) * (4ULL << fake.pr);
    CHECK(counts * 1000 <= static_cast<std::uint64_t>(ms) * kLsiStm32f4.slowest_hz);
    CHECK(counts * 1000 > static_cast<std::uint64_t>(ms) * kLsiStm32f4.slowest_hz * 7 / 10);
  }
  CHECK(longest > 60'000);
  CHECK(!dog.start(Duration::from_ms(0)));
  CHECK(!dog.start(Duration::from_ms(-5)));
  CHECK(!dog.start(Duration::from_ms(80'000)));
}

TEST(Iwdg, AnOscillatorThatStandsIsTold) {
  fake.oscillates = false;
  CHECK(!dog.start(Duration::from_ms(100)));
}

TEST(Iwdg, FeedingReloads) {
  CHECK(dog.start(Duration::from_ms(100)));
  const std::uint32_t before = fake.reloads;
  dog.feed();
  LONGS_EQUAL(before + 1, fake.reloads);
}

TEST(Iwdg, ABiteIsToldUntilItIsForgotten) {
  CHECK(!dog.has_bitten());
  rcc_csr.write(1U << 29);
  CHECK(dog.has_bitten());
  dog.forget_bite();
  CHECK((rcc_csr.read() >> 24 & 1U) != 0);
}
