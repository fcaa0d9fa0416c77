// SPDX-License-Identifier: Apache-2.0
// What the flash controllers of both parts do alike: RM0090 3.6.1 and 3.9, RM0440 3.3.5 and 3.7.
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {

inline constexpr std::uint32_t kFlashBusy = 1U << 16, kFlashDone = 1U << 0;  ///< of the status register

/// Opens the control register for an erasure or a word, and shuts it again.
class FlashLock {
 public:
  /// `errors`: flags of the status register that stand for a failure, cleared by ones.
  FlashLock(Register& keys, Register& status, Register& control, std::uint32_t errors)
      : keys_(keys), status_(status), control_(control), errors_(errors) {}

  /// With no error left from before: the flags block what follows until they are cleared.
  [[nodiscard]] bool open() {
    if (!wait_clear(status_, kFlashBusy)) return false;
    if ((control_.read() & kLock) != 0) {
      keys_.write(kKey1);
      keys_.write(kKey2);
    }
    status_.write(errors_ | kFlashDone);
    return (control_.read() & kLock) == 0;
  }
  /// True when nothing went wrong in between.
  [[nodiscard]] bool shut() {
    const bool good = (status_.read() & (errors_ | kFlashBusy)) == 0;
    status_.write(errors_ | kFlashDone);
    control_.write(kLock);
    return good;
  }

 private:
  static constexpr std::uint32_t kKey1 = 0x4567'0123U, kKey2 = 0xCDEF'89ABU, kLock = 1U << 31;

  Register& keys_;
  Register& status_;
  Register& control_;
  std::uint32_t errors_;
};

/// Four bytes, the first lowest, as the word that flash is written by, and flash as bytes.
inline std::uint32_t flash_word(const std::uint8_t* b) {
  return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
}
inline void read_flash(Register* words, std::size_t offset, std::uint8_t* bytes, std::size_t count) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = offset + i;
    if (i == 0 || at % 4 == 0) word = words[at / 4].read();
    bytes[i] = static_cast<std::uint8_t>(word >> (8 * (at % 4)));
  }
}

}  // namespace voltlap::port::stm32
