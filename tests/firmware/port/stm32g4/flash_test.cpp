// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/flash.hpp"

#include <functional>
#include <vector>

#include "firmware/port/stm32/fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port::stm32g4;
using voltlap::port::stm32::test::Attached;
using voltlap::port::stm32::test::Model;

namespace {

constexpr std::size_t kPageBytes = 256, kPages = 2;
constexpr std::uint32_t kLock = 1U << 31, kBsy = 1U << 16, kPgserr = 1U << 7, kProgerr = 1U << 3, kWrperr = 1U << 4;
constexpr std::uint32_t kEccd = 1U << 31;

/// RM0440 chapter 3: a double word at once, low word first, onto blank cells only (or all zeros); errors stand until
/// they are cleared by ones and block what follows; reading what ECC cannot mend sets ECCD, which ones clear.
class FakeFlash final : public Model {
 public:
  FlashRegisters block{};
  std::uint32_t sr = 0, cr = kLock, eccr = 0;
  bool wrong_key = false, protect = false, busy_forever = false;
  int erased = -1;
  std::function<void(std::size_t page)> on_erase;

  std::uint32_t read(std::size_t offset) override {
    switch (offset) {
      case 0x10:
        if (busy_ > 0 && !busy_forever) --busy_;
        return sr | (busy_ > 0 ? kBsy : 0U);
      case 0x14: return cr;
      case 0x18: return eccr;
      default: return 0;
    }
  }
  void write(std::size_t offset, std::uint32_t value) override {
    switch (offset) {
      case 0x08: key(value); break;
      case 0x10: sr &= ~value; break;
      case 0x14: write_cr(value); break;
      case 0x18: eccr &= ~(value & (kEccd | 1U << 30)); break;
      default: break;
    }
  }
  bool takes_words(bool blank, bool zeros) {
    if ((cr & kLock) != 0 || (cr & 1U) == 0 || (sr & 0xC3FAU) != 0) return set(kPgserr);
    if (protect) return set(kWrperr);
    if (!blank && !zeros) return set(kProgerr);
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
    cr = value;
    if ((cr >> 16 & 1U) == 0 || (cr >> 1 & 1U) == 0) return;
    if (protect || (sr & 0xC3FAU) != 0) {
      sr |= kWrperr;
      return;
    }
    erased = static_cast<int>((cr >> 3 & 0x7FU) + ((cr >> 11 & 1U) != 0 ? 128 : 0));
    busy_ = 100;
    if (on_erase) on_erase(static_cast<std::size_t>(erased));
    cr &= ~(1U << 16);
  }
  bool first_ = false;
  int busy_ = 0;
};

class FakeMemory final : public Model {
 public:
  explicit FakeMemory(FakeFlash& flash) : flash_(flash), words(2 * kPages * kPageBytes / 4, ~0U) {
    flash.on_erase = [this](std::size_t page) {
      for (std::size_t i = 0; i < kPageBytes / 4; ++i) words[(page - 132) * kPageBytes / 4 + i] = ~0U;
    };
  }
  std::uint32_t read(std::size_t offset) override {
    if (offset / 8 == beyond_mending) flash_.eccr |= kEccd;
    return words[offset / 4];
  }
  void write(std::size_t offset, std::uint32_t value) override {
    if (offset % 8 == 0) {
      low_ = value;
      return;
    }
    std::uint32_t* const at = &words[offset / 4 - 1];
    if (!flash_.takes_words(at[0] == ~0U && at[1] == ~0U, low_ == 0 && value == 0)) return;
    at[0] &= low_;
    at[1] &= value;
  }

 private:
  FakeFlash& flash_;
  std::uint32_t low_ = 0;

 public:
  std::vector<std::uint32_t> words;
  std::size_t beyond_mending = ~std::size_t{0};  ///< double word
};

}  // namespace

TEST_GROUP(PageFlash) {
  FakeFlash fake;
  FakeMemory memory{fake};
  Register words[2 * kPages * kPageBytes / 4];
  Attached registers{&fake.block, sizeof fake.block, fake};
  Attached area{words, sizeof words, memory};
  PageFlash flash{fake.block, {4, true, words}, {6, true, words + kPages * kPageBytes / 4}, kPages, kPageBytes};
  std::uint8_t unit[8] = {0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88};
};

TEST(PageFlash, ADoubleWordIsProgrammedWhereItBelongsAndReadsBack) {
  CHECK(flash.program(1, 8, unit));
  UNSIGNED_LONGS_EQUAL(0x44332211, memory.words[kPages * kPageBytes / 4 + 2]);
  std::uint8_t back[10] = {};
  CHECK(flash.read(1, 7, back, 10));
  const std::uint8_t expected[10] = {0xFF, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88, 0xFF};
  MEMCMP_EQUAL(expected, back, 10);
  CHECK((fake.cr & kLock) != 0);
  CHECK(!fake.wrong_key);
}

TEST(PageFlash, ErasingTakesAllPagesOfTheAreaInItsBank) {
  for (std::size_t at = 0; at < flash.area_bytes(); at += 8) {
    CHECK(flash.program(0, at, unit) && flash.program(1, at, unit));
  }
  CHECK(flash.erase(1));
  LONGS_EQUAL(128 + 7, fake.erased);
  for (std::size_t i = 0; i < memory.words.size(); ++i) {
    UNSIGNED_LONGS_EQUAL(i < memory.words.size() / 2 ? (i % 2 == 0 ? 0x44332211U : 0x88776655U) : ~0U, memory.words[i]);
  }
}

TEST(PageFlash, AnErrorIsToldAndDoesNotBlockWhatFollows) {
  fake.protect = true;
  CHECK(!flash.program(0, 0, unit));
  CHECK(!flash.erase(0));
  fake.protect = false;
  fake.sr |= kPgserr;  // left by somebody else
  CHECK(flash.program(0, 0, unit));
  CHECK(flash.erase(0));
}

TEST(PageFlash, ADoubleWordThatIsNotBlankIsToldAndZerosAreTaken) {
  CHECK(flash.program(0, 0, unit));
  CHECK(!flash.program(0, 0, unit));
  const std::uint8_t zeros[8] = {};
  CHECK(flash.program(0, 0, zeros));
  UNSIGNED_LONGS_EQUAL(0, memory.words[0] | memory.words[1]);
}

TEST(PageFlash, WhatECCCannotMendIsToldWhoeverClearsTheFlagFirst) {
  CHECK(flash.program(0, 0, unit) && flash.program(0, 8, unit));
  memory.beyond_mending = 1;
  std::uint8_t back[8];
  CHECK(flash.read(0, 0, back, 8));
  CHECK(!flash.read(0, 8, back, 8));
  CHECK(flash.read(0, 0, back, 8));
  CHECK(!flash.on_nmi());
  fake.eccr = kEccd;
  CHECK(flash.on_nmi());
  UNSIGNED_LONGS_EQUAL(0, fake.eccr);
  CHECK(flash.read(0, 0, back, 8));  // what the NMI told was before this read
}

TEST(PageFlash, AFlashThatNeverEndsIsGivenUp) {
  fake.busy_forever = true;
  CHECK(!flash.program(0, 0, unit));
  CHECK(!flash.program(0, 8, unit));
}

TEST(PageFlash, WhatLiesOutsideIsRefused) {
  CHECK(!flash.program(2, 0, unit) && !flash.program(0, 2, unit) && !flash.program(0, flash.area_bytes(), unit));
  CHECK(!flash.erase(2));
  std::uint8_t byte = 0;
  CHECK(!flash.read(0, flash.area_bytes(), &byte, 1) && !flash.read(2, 0, &byte, 1));
}
