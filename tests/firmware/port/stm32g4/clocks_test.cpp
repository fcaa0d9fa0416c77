// SPDX-License-Identifier: Apache-2.0
#include "firmware/port/stm32/fake_registers.hpp"

#include <CppUTest/TestHarness.h>

#include "port/stm32/can_timing.hpp"
#include "port/stm32g4/system_registers.hpp"

using namespace voltlap::port::stm32g4;
using voltlap::port::stm32::test::Attached;
using voltlap::port::stm32::test::Model;

namespace {

constexpr std::uint32_t kMHz = 1'000'000;

/// RM0440 3.3.3 and chapter 7: the crystal and the PLL are ready some reads after they were turned on, the PLL takes
/// its settings only while it is off, a switch comes some reads later, and flash that is read faster than its wait
/// states allow gives anything.
class FakeClocks final : public Model {
 public:
  RccRegisters block{};
  voltlap::port::stm32::Register acr;
  bool has_crystal = true, pll_locks = true, switches = true;
  bool beyond_flash = false, jumped = false;  ///< what must never be
  int reads_at_half = 0;

  FakeClocks() { acr.write(0x0004'0600U); }

  std::uint32_t read(std::size_t offset) override {
    if (wait_ > 0) --wait_;
    if (offset == 0x00) {
      const bool hse = (cr_ & 1U << 16) != 0 && has_crystal && wait_ == 0;
      const bool pll = (cr_ & 1U << 24) != 0 && pll_locks && wait_ == 0 && has_crystal;
      return cr_ | (hse ? 1U << 17 : 0U) | (pll ? 1U << 25 : 0U);
    }
    if (offset == 0x08) {
      if ((cfgr_ & 3U) == 3U && switches && wait_ == 0) cfgr_ |= 3U << 2;
      if (core_hz() == 72 * kMHz) ++reads_at_half;
      look();
      return cfgr_;
    }
    return offset == 0x0C ? pllcfgr_ : 0U;
  }
  void write(std::size_t offset, std::uint32_t value) override {
    const std::uint32_t before = core_hz();
    if (offset == 0x00) cr_ = value;
    if (offset == 0x08) cfgr_ = (value & ~(3U << 2)) | (cfgr_ & 3U << 2);
    if (offset == 0x0C && (cr_ & 1U << 24) == 0) pllcfgr_ = value;
    if (core_hz() == before) wait_ = 20;
    if (before < 72 * kMHz && core_hz() > 80 * kMHz) jumped = true;
    look();
  }
  [[nodiscard]] std::uint32_t core_hz() const {
    const std::uint32_t half = (cfgr_ >> 4 & 0xFU) == 8U ? 2 : 1;
    if ((cfgr_ >> 2 & 3U) != 3U) return 16 * kMHz / half;
    return pll_hz() / half;
  }
  [[nodiscard]] std::uint32_t pll_hz() const {
    if ((pllcfgr_ & 3U) != 3U || (pllcfgr_ & 1U << 24) == 0) return 0;
    return kCrystal_hz / ((pllcfgr_ >> 4 & 0xFU) + 1U) * (pllcfgr_ >> 8 & 0x7FU) / (2U * ((pllcfgr_ >> 25 & 3U) + 1U));
  }
  [[nodiscard]] std::uint32_t pll_input_hz() const { return kCrystal_hz / ((pllcfgr_ >> 4 & 0xFU) + 1U); }
  [[nodiscard]] std::uint32_t vco_hz() const { return pll_input_hz() * (pllcfgr_ >> 8 & 0x7FU); }
  [[nodiscard]] std::uint32_t buses() const { return cfgr_ >> 8 & 0x3FU; }

 private:
  void look() {
    const std::uint32_t most = 30 * kMHz * ((acr.read() & 0xFU) + 1U);  // table 9, range 1 without boost
    if (core_hz() > most) beyond_flash = true;
  }

  std::uint32_t cr_ = 1U << 8 | 1U << 10, cfgr_ = 1U | 1U << 2 | 5U << 8, pllcfgr_ = 0x1000;
  int wait_ = 0;
};

class StuckRegister final : public Model {
 public:
  std::uint32_t read(std::size_t) override { return 0x0004'0600U; }
  void write(std::size_t, std::uint32_t) override {}
};

}  // namespace

TEST_GROUP(G4Clocks) {
  FakeClocks fake;
  Attached attached{&fake.block, sizeof fake.block, fake};
};

TEST(G4Clocks, TheProcessorComesUpWith144MHzByWayOfHalfOfItWithinWhatFlashAndPllAllow) {
  CHECK(start_clocks(fake.block, fake.acr));
  UNSIGNED_LONGS_EQUAL(kCore_hz, fake.core_hz());
  UNSIGNED_LONGS_EQUAL(0, fake.buses());
  CHECK(!fake.beyond_flash && !fake.jumped);
  CHECK(fake.reads_at_half * 8 >= 72);  // a microsecond at 72 MHz
  CHECK(fake.pll_input_hz() >= 2'660'000 && fake.pll_input_hz() <= 16 * kMHz);  // 7.4.4
  CHECK(fake.vco_hz() >= 96 * kMHz && fake.vco_hz() <= 344 * kMHz);             // DS12288, "PLL characteristics"
  UNSIGNED_LONGS_EQUAL(4U | 7U << 8 | 1U << 18, fake.acr.read());               // prefetch, both caches, the debugger
}

TEST(G4Clocks, WhatDoesNotComeUpIsToldAndTheProcessorStaysAtItsInternalOscillator) {
  for (bool FakeClocks::*part : {&FakeClocks::has_crystal, &FakeClocks::pll_locks}) {
    FakeClocks lame;
    lame.*part = false;
    const Attached here(&lame.block, sizeof lame.block, lame);
    CHECK(!start_clocks(lame.block, lame.acr));
    UNSIGNED_LONGS_EQUAL(16 * kMHz, lame.core_hz());
  }
}

TEST(G4Clocks, FlashThatDoesNotTakeItsWaitStatesIsToldBeforeTheClockRises) {
  StuckRegister stuck;
  const Attached here(&fake.acr, sizeof fake.acr, stuck);
  CHECK(!start_clocks(fake.block, fake.acr));
  UNSIGNED_LONGS_EQUAL(16 * kMHz, fake.core_hz());
}

TEST(G4Clocks, ASwitchThatDoesNotComeIsTold) {
  fake.switches = false;
  CHECK(!start_clocks(fake.block, fake.acr));
}

TEST(G4Clocks, TheCrystalAloneMakesTheBitsOfTheBus) {
  const auto timing = voltlap::port::stm32::can_timing(kCrystal_hz, 500'000, voltlap::port::stm32::kFdCanLimits);
  CHECK(timing.prescaler != 0);
  UNSIGNED_LONGS_EQUAL(kCrystal_hz / 500'000, timing.prescaler * (1U + timing.segment1 + timing.segment2));
}
