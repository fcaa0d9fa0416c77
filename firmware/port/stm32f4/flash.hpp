// SPDX-License-Identifier: Apache-2.0
// Sectors of the STM32F4's flash as two areas (RM0090 chapter 3). Single bank: the processor stands still while it is
// erased or programmed: 16 us a word, 100 us at most; 1 s, 2 s at most a sector of 128 kB (DS8626 "Flash memory
// programming", 32 bits at a time).
#pragma once
#include "port/flash/flash.hpp"
#include "port/stm32/flash_lock.hpp"

namespace voltlap::port::stm32f4 {

using stm32::Register;

struct FlashRegisters {  // 3.9
  Register acr;      // 0x00
  Register keyr;     // 0x04
  Register optkeyr;  // 0x08
  Register sr;       // 0x0C
  Register cr;       // 0x10
  Register optcr;    // 0x14
};
static_assert(offsetof(FlashRegisters, optcr) == 0x14);

inline constexpr std::uint32_t kFlashErrors = 1U << 1 | 1U << 4 | 1U << 5 | 1U << 6 | 1U << 7;  // of sr, 3.9.4

class SectorFlash final : public Flash {
 public:
  /// The number of its first sector in CR.SNB, and that sector's first word in memory.
  struct Area {
    std::uint8_t number = 0;
    Register* words = nullptr;
  };
  /// Areas of `sectors` sectors each, which lie behind each other and are of one size.
  SectorFlash(FlashRegisters& registers, Area first, Area second, std::size_t sectors, std::size_t sector_bytes)
      : regs_(registers), lock_(registers.keyr, registers.sr, registers.cr, kFlashErrors), area_{first, second},
         sectors_(sectors), sector_bytes_(sector_bytes) {}

  [[nodiscard]] std::size_t unit() const override { return 4; }
  [[nodiscard]] std::size_t area_bytes() const override { return sectors_ * sector_bytes_; }
  bool erase(std::size_t area) override;
  bool program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) override;
  bool read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) override;

 private:
  void forget_cached();

  FlashRegisters& regs_;
  stm32::FlashLock lock_;
  Area area_[kFlashAreas];
  std::size_t sectors_;
  std::size_t sector_bytes_;
};

}  // namespace voltlap::port::stm32f4
