// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/flash.hpp"

namespace voltlap::port::stm32f4 {
namespace {

constexpr std::uint32_t kKey1 = 0x4567'0123U, kKey2 = 0xCDEF'89ABU;                        // 3.6.1
constexpr std::uint32_t kPg = 1U << 0, kSer = 1U << 1, kPsize32 = 2U << 8, kStrt = 1U << 16, kLock = 1U << 31;  // 3.9.5
constexpr unsigned kSnbShift = 3;
constexpr std::uint32_t kBsy = 1U << 16, kErrors = 1U << 1 | 1U << 4 | 1U << 5 | 1U << 6 | 1U << 7;  // 3.9.4
constexpr std::uint32_t kEop = 1U << 0;
constexpr std::uint32_t kDcen = 1U << 10, kDcrst = 1U << 12;  // 3.9.1
// 2 s at 168 MHz and 8 cycles a read; the processor stands still anyway where it runs from the same flash.
constexpr std::uint32_t kEraseReads = 42'000'000U;

std::uint32_t word_from(const std::uint8_t* b) {
  return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
}

}  // namespace

/// Unlocked, with no error left from before: the flags are cleared by ones, and block what follows until then.
bool SectorFlash::begin() {
  if (!stm32::wait_clear(regs_.sr, kBsy)) return false;
  if ((regs_.cr.read() & kLock) != 0) {
    regs_.keyr.write(kKey1);
    regs_.keyr.write(kKey2);
  }
  regs_.sr.write(kErrors | kEop);
  return (regs_.cr.read() & kLock) == 0;
}

bool SectorFlash::end() {
  const bool good = (regs_.sr.read() & (kErrors | kBsy)) == 0;
  regs_.sr.write(kErrors | kEop);
  regs_.cr.write(kLock);
  return good;
}

/// 3.5.2: after an erasure the data cache still holds what stood there.
void SectorFlash::forget_cached() {
  const bool cached = (regs_.acr.read() & kDcen) != 0;
  regs_.acr.clear(kDcen);
  regs_.acr.set(kDcrst);
  regs_.acr.clear(kDcrst);
  if (cached) regs_.acr.set(kDcen);
}

bool SectorFlash::erase(std::size_t area) {
  if (area >= kFlashAreas) return false;
  bool good = true;
  for (std::size_t i = 0; good && i < sectors_; ++i) {
    if (!begin()) return false;
    const auto number = static_cast<std::uint32_t>(area_[area].number + i);
    regs_.cr.write(kSer | kPsize32 | number << kSnbShift);
    regs_.cr.set(kStrt);
    static_cast<void>(stm32::wait_clear(regs_.sr, kBsy, kEraseReads));
    good = end();
  }
  forget_cached();
  return good;
}

bool SectorFlash::program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) {
  if (area >= kFlashAreas || offset % unit() != 0 || offset + unit() > area_bytes() || !begin()) return false;
  regs_.cr.write(kPg | kPsize32);
  Register& word = area_[area].words[offset / unit()];
  const std::uint32_t value = word_from(unit_bytes);
  word.write(value);
  static_cast<void>(stm32::wait_clear(regs_.sr, kBsy));
  return end() && word.read() == value;
}

bool SectorFlash::read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) {
  if (area >= kFlashAreas || offset > area_bytes() || count > area_bytes() - offset) return false;
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = offset + i;
    if (i == 0 || at % 4 == 0) word = area_[area].words[at / 4].read();
    bytes[i] = static_cast<std::uint8_t>(word >> (8 * (at % 4)));
  }
  return true;
}

}  // namespace voltlap::port::stm32f4
