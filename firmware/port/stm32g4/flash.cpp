// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/flash.hpp"

namespace voltlap::port::stm32g4 {
namespace {

constexpr std::uint32_t kPg = 1U << 0, kPer = 1U << 1, kBker = 1U << 11, kStrt = 1U << 16;  // 3.7.6
constexpr unsigned kPnbShift = 3;
constexpr std::uint32_t kEccd = 1U << 31, kEccc = 1U << 30;                                 // 3.7.7

}  // namespace

bool PageFlash::erase(std::size_t area) {
  if (area >= kFlashAreas) return false;
  const Area& a = area_[area];
  for (std::size_t page = 0; page < pages_; ++page) {
    if (!lock_.open()) return false;
    const auto number = static_cast<std::uint32_t>(a.number + page);
    regs_.cr.write(kPer | (a.bank2 ? kBker : 0U) | number << kPnbShift);
    regs_.cr.set(kStrt);
    static_cast<void>(stm32::wait_clear(regs_.sr, stm32::kFlashBusy, 10 * stm32::kHandshakeReads));
    if (!lock_.shut()) return false;
  }
  return true;
}

bool PageFlash::program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) {
  if (area >= kFlashAreas || offset % unit() != 0 || offset + unit() > area_bytes() || !lock_.open()) return false;
  regs_.cr.write(kPg);
  Register* const words = area_[area].words + offset / 4;
  words[0].write(stm32::flash_word(unit_bytes));  // 3.3.7: the low word first; the high one starts the programming
  words[1].write(stm32::flash_word(unit_bytes + 4));
  static_cast<void>(stm32::wait_clear(regs_.sr, stm32::kFlashBusy));
  if (!lock_.shut()) return false;
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
  stm32::read_flash(area_[area].words, offset, bytes, count);
  const bool cut = (regs_.eccr.read() & kEccd) != 0 || __atomic_load_n(&beyond_mending_, __ATOMIC_ACQUIRE);
  regs_.eccr.write(kEccd | kEccc);
  return !cut;
}

}  // namespace voltlap::port::stm32g4
