// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/flash.hpp"

#include <functional>
#include <vector>

#include "firmware/port/stm32/fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port::stm32f4;
using voltlap::port::stm32::test::Attached;
using voltlap::port::stm32::test::Model;

namespace {

constexpr std::size_t kSectorBytes = 256, kSectors = 2;
constexpr std::uint32_t kLock = 1U << 31, kBsy = 1U << 16, kPgserr = 1U << 7, kPgperr = 1U << 6, kWrperr = 1U << 4;

/// RM0090 chapter 3: keys in their order unlock, a wrong one locks until reset; errors stand until they are cleared by
/// ones and block what follows; programming takes PG and the width of the access, and only clears bits.
class FakeFlash final : public Model {
 public:
  FlashRegisters block{};
  std::uint32_t acr = 1U << 10, sr = 0, cr = kLock;
  bool wrong_key = false, protect = false, busy_forever = false, cache_was_reset = false;
  int erased = -1;
  std::function<void(std::size_t sector)> on_erase;

  std::uint32_t read(std::size_t offset) override {
    switch (offset) {
      case 0x00: return acr;
      case 0x0C:
        if (busy_ > 0 && !busy_forever) --busy_;
        return sr | (busy_ > 0 ? kBsy : 0U);
      case 0x10: return cr;
      default: return 0;  // KEYR is write-only
    }
  }
  void write(std::size_t offset, std::uint32_t value) override {
    switch (offset) {
      case 0x00:
        if ((value >> 12 & 1U) != 0 && (acr >> 10 & 1U) == 0) cache_was_reset = true;  // DCRST only while DCEN is off
        acr = value;
        break;
      case 0x04: key(value); break;
      case 0x0C: sr &= ~(value & 0xF3U); break;
      case 0x10: write_cr(value); break;
      default: break;
    }
  }
  /// The flash takes a word: true when it is programmed.
  bool takes_word() {
    if ((cr & kLock) != 0 || (cr & 1U) == 0 || (sr & 0xF2U) != 0) return set(kPgserr);
    if ((cr >> 8 & 3U) != 2) return set(kPgperr);
    if (protect) return set(kWrperr);
    busy_ = 4;
    return true;
  }

 private:
  bool set(std::uint32_t error) {
    sr |= error;
    return false;
  }
  void key(std::uint32_t value) {
    const bool first = value == 0x4567'0123U && !first_;
    const bool second = value == 0xCDEF'89ABU && first_;
    if (!first && !second) wrong_key = true;
    first_ = first;
    if (second && !wrong_key) cr &= ~kLock;
  }
  void write_cr(std::uint32_t value) {
    if ((cr & kLock) != 0) return;
    cr = value & 0x8301'03FFU;
    if ((cr >> 16 & 1U) == 0 || (cr >> 1 & 1U) == 0) return;
    if (protect || (sr & 0xF2U) != 0) {
      sr |= kWrperr;
      return;
    }
    erased = static_cast<int>(cr >> 3 & 0xFU);
    busy_ = 100;
    if (on_erase) on_erase(static_cast<std::size_t>(erased));
    cr &= ~(1U << 16);
  }
  bool first_ = false;
  int busy_ = 0;
};

class FakeMemory final : public Model {
 public:
  explicit FakeMemory(FakeFlash& flash) : flash_(flash), words(2 * kSectors * kSectorBytes / 4, ~0U) {
    flash.on_erase = [this](std::size_t sector) {
      for (std::size_t i = 0; i < kSectorBytes / 4; ++i) words[(sector - 8) * kSectorBytes / 4 + i] = ~0U;
    };
  }
  std::uint32_t read(std::size_t offset) override { return words[offset / 4]; }
  void write(std::size_t offset, std::uint32_t value) override {
    if (flash_.takes_word()) words[offset / 4] &= value;
  }

 private:
  FakeFlash& flash_;

 public:
  std::vector<std::uint32_t> words;
};

}  // namespace

TEST_GROUP(SectorFlash) {
  FakeFlash fake;
  FakeMemory memory{fake};
  Register words[2 * kSectors * kSectorBytes / 4];
  Attached registers{&fake.block, sizeof fake.block, fake};
  Attached area{words, sizeof words, memory};
  SectorFlash flash{fake.block, {8, words}, {10, words + kSectors * kSectorBytes / 4}, kSectors, kSectorBytes};
  std::uint8_t unit[4] = {0x11, 0x22, 0x33, 0x44};
};

TEST(SectorFlash, AWordIsProgrammedWhereItBelongsAndReadsBack) {
  CHECK(flash.program(1, 8, unit));
  UNSIGNED_LONGS_EQUAL(0x44332211, memory.words[kSectors * kSectorBytes / 4 + 2]);
  std::uint8_t back[6] = {};
  CHECK(flash.read(1, 7, back, 6));
  const std::uint8_t expected[6] = {0xFF, 0x11, 0x22, 0x33, 0x44, 0xFF};
  MEMCMP_EQUAL(expected, back, 6);
  CHECK((fake.cr & kLock) != 0);
  CHECK(!fake.wrong_key);
}

TEST(SectorFlash, ErasingTakesAllSectorsOfTheAreaAndForgetsWhatWasCached) {
  for (std::size_t at = 0; at < flash.area_bytes(); at += 4) {
    CHECK(flash.program(0, at, unit) && flash.program(1, at, unit));
  }
  CHECK(flash.erase(1));
  LONGS_EQUAL(11, fake.erased);
  for (std::size_t i = 0; i < memory.words.size(); ++i) {
    UNSIGNED_LONGS_EQUAL(i < memory.words.size() / 2 ? 0x44332211U : ~0U, memory.words[i]);
  }
  CHECK(fake.cache_was_reset);
  CHECK((fake.acr >> 10 & 1U) != 0);
}

TEST(SectorFlash, AnErrorIsToldAndDoesNotBlockWhatFollows) {
  fake.protect = true;
  CHECK(!flash.program(0, 0, unit));
  CHECK(!flash.erase(0));
  fake.protect = false;
  fake.sr |= kPgserr;  // left by somebody else
  CHECK(flash.program(0, 0, unit));
  CHECK(flash.erase(0));
}

TEST(SectorFlash, AWordThatDoesNotReadBackIsTold) {
  memory.words[0] = 0;
  CHECK(!flash.program(0, 0, unit));
}

TEST(SectorFlash, AFlashThatNeverEndsIsGivenUp) {
  fake.busy_forever = true;
  CHECK(!flash.program(0, 0, unit));
  CHECK(!flash.program(0, 4, unit));
}

TEST(SectorFlash, WhatLiesOutsideIsRefused) {
  CHECK(!flash.program(2, 0, unit) && !flash.program(0, 2, unit) && !flash.program(0, flash.area_bytes(), unit));
  CHECK(!flash.erase(2));
  std::uint8_t byte = 0;
  CHECK(!flash.read(0, flash.area_bytes(), &byte, 1) && !flash.read(2, 0, &byte, 1));
}
