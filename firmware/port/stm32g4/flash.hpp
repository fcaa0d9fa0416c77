// SPDX-License-Identifier: Apache-2.0
// Pages of the STM32G4's flash as two areas (RM0440 chapter 3, category 3 devices), programmed by double words. On
// parts with two banks the areas lie in bank 2 and code runs on from bank 1 while they are written; 22 ms a page, 82
// us a double word (DS12288).
//
// A double word carries ECC. One that was cut off may be beyond mending: reading it sets ECCR.ECCD, which raises the
// NMI until it is cleared. NMI_Handler calls on_nmi and returns.
#pragma once
#include "port/flash/flash.hpp"
#include "port/stm32/flash_lock.hpp"

namespace voltlap::port::stm32g4 {

using stm32::Register;

struct FlashRegisters {  // 3.7
  Register acr;      // 0x00
  Register pdkeyr;   // 0x04
  Register keyr;     // 0x08
  Register optkeyr;  // 0x0C
  Register sr;       // 0x10
  Register cr;       // 0x14
  Register eccr;     // 0x18
  Register reserved;
  Register optr;     // 0x20
};
static_assert(offsetof(FlashRegisters, eccr) == 0x18 && offsetof(FlashRegisters, optr) == 0x20);

inline constexpr std::uint32_t kFlashErrors = 0x3FAU | 1U << 14 | 1U << 15;  // of sr, 3.7.5

class PageFlash final : public Flash {
 public:
  /// `pages` of `page_bytes` from page `number` of the bank on, beginning at `words` in memory.
  struct Area {
    std::uint8_t number = 0;
    bool bank2 = false;
    Register* words = nullptr;
  };
  PageFlash(FlashRegisters& registers, Area first, Area second, std::size_t pages, std::size_t page_bytes)
      : regs_(registers), lock_(registers.keyr, registers.sr, registers.cr, kFlashErrors), area_{first, second},
         pages_(pages), page_bytes_(page_bytes) {}

  [[nodiscard]] std::size_t unit() const override { return 8; }
  [[nodiscard]] std::size_t area_bytes() const override { return pages_ * page_bytes_; }
  bool erase(std::size_t area) override;
  bool program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) override;
  bool read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) override;

  /// True when the NMI was for what the flash could not mend; other reasons for it are the board's.
  bool on_nmi();

 private:
  FlashRegisters& regs_;
  stm32::FlashLock lock_;
  Area area_[kFlashAreas];
  std::size_t pages_;
  std::size_t page_bytes_;
  bool beyond_mending_ = false;
};

}  // namespace voltlap::port::stm32g4
