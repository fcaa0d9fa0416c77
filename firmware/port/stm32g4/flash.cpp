// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/flash.hpp"

namespace voltlap::port::stm32g4 {
namespace {

constexpr std::uint32_t kKey1 = 0x4567'0123U, kKey2 = 0xCDEF'89ABU;                                  // 3.3.5
constexpr std::uint32_t kPg = 1U << 0, kPer = 1U << 1, kBker = 1U << 11, kStrt = 1U << 16, kLock = 1U << 31;  // 3.7.6
constexpr unsigned kPnbShift = 3;
constexpr std::uint32_t kBsy = 1U << 16, kErrors = 0x3FAU | 1U << 14 | 1U << 15, kEop = 1U << 0;     // 3.7.5
constexpr std::uint32_t kEccd = 1U << 31, kEccc = 1U << 30;                                         // 3.7.7

std::uint32_t word_from(const std::uint8_t* b) {
  return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
}

}  // namespace

bool PageFlash::begin() {
  if (!stm32::wait_clear(regs_.sr, kBsy)) return false;
  if ((regs_.cr.read() & kLock) != 0) {
    regs_.keyr.write(kKey1);
    regs_.keyr.write(kKey2);
  }
  regs_.sr.write(kErrors | kEop);
  return (regs_.cr.read() & kLock) == 0;
}

bool PageFlash::end() {
  const bool good = (regs_.sr.read() & (kErrors | kBsy)) == 0;
  regs_.sr.write(kErrors | kEop);
  regs_.cr.write(kLock);
  return good;
}

bool PageFlash::erase(std::size_t area) {
  if (area >= kFlashAreas) return false;
  const Area& a = area_[area];
  for (std::size_t page = 0; page < pages_; ++page) {
    if (!begin()) return false;
    const auto number = static_cast<std::uint32_t>(a.number + page);
    regs_.cr.write(kPer | (a.bank2 ? kBker : 0U) | number << kPnbShift);
    regs_.cr.set(kStrt);
    static_cast<void>(stm32::wait_clear(regs_.sr, kBsy, 10 * stm32::kHandshakeReads));
    if (!end()) return false;
  }
  return true;
}

bool PageFlash::program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) {
  if (area >= kFlashAreas || offset % unit() != 0 || offset + unit() > area_bytes() || !begin()) return false;
  regs_.cr.write(kPg);
  Register* const words = area_[area].words + offset / 4;
  words[0].write(word_from(unit_bytes));  // 3.3.7: the low word first; the high one starts the programming
  words[1].write(word_from(unit_bytes + 4));
  static_cast<void>(stm32::wait_clear(regs_.sr, kBsy));
  if (!end()) return false;
  std::uint8_t back[kFlashUnitMost];
  if (!read(area, offset, back, unit())) return false;
  for (std::size_t i = 0; i < unit(); ++i) {
    if (back[i] != unit_bytes[i]) return false;
  }
  return true;
}

bool PageFlash::on_nmi() {
  if ((regs_.eccr.read() & kEccd) == 0) return false;
  regs_.eccr.write(kEccd);
  __atomic_store_n(&beyond_mending_, true, __ATOMIC_RELEASE);
  return true;
}

bool PageFlash::read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) {
  if (area >= kFlashAreas || offset > area_bytes() || count > area_bytes() - offset) return false;
  regs_.eccr.write(kEccd | kEccc);
  __atomic_store_n(&beyond_mending_, false, __ATOMIC_RELEASE);
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = offset + i;
    if (i == 0 || at % 4 == 0) word = area_[area].words[at / 4].read();
    bytes[i] = static_cast<std::uint8_t>(word >> (8 * (at % 4)));
  }
  const bool cut = (regs_.eccr.read() & kEccd) != 0 || __atomic_load_n(&beyond_mending_, __ATOMIC_ACQUIRE);
  regs_.eccr.write(kEccd | kEccc);
  return !cut;
}

}  // namespace voltlap::port::stm32g4
