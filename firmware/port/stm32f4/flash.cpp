// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/flash.hpp"

namespace voltlap::port::stm32f4 {
namespace {

constexpr std::uint32_t kPg = 1U << 0, kSer = 1U << 1, kPsize32 = 2U << 8, kStrt = 1U << 16;  // 3.9.5
constexpr unsigned kSnbShift = 3;
constexpr std::uint32_t kDcen = 1U << 10, kDcrst = 1U << 12;  // 3.9.1
// 2 s at 168 MHz and 8 cycles a read; the processor stands still anyway where it runs from the same flash.
constexpr std::uint32_t kEraseReads = 42'000'000U;

}  // namespace

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
    if (!lock_.open()) return false;
    const auto number = static_cast<std::uint32_t>(area_[area].number + i);
    regs_.cr.write(kSer | kPsize32 | number << kSnbShift);
    regs_.cr.set(kStrt);
    static_cast<void>(stm32::wait_clear(regs_.sr, stm32::kFlashBusy, kEraseReads));
    good = lock_.shut();
  }
  forget_cached();
  return good;
}

bool SectorFlash::program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) {
  if (area >= kFlashAreas || offset % unit() != 0 || offset + unit() > area_bytes() || !lock_.open()) return false;
  regs_.cr.write(kPg | kPsize32);
  Register& word = area_[area].words[offset / unit()];
  const std::uint32_t value = stm32::flash_word(unit_bytes);
  word.write(value);
  static_cast<void>(stm32::wait_clear(regs_.sr, stm32::kFlashBusy));
  return lock_.shut() && word.read() == value;
}

bool SectorFlash::read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) {
  if (area >= kFlashAreas || offset > area_bytes() || count > area_bytes() - offset) return false;
  stm32::read_flash(area_[area].words, offset, bytes, count);
  return true;
}

}  // namespace voltlap::port::stm32f4
