// SPDX-License-Identifier: Apache-2.0
// What a board of the STM32G4 needs to come up: reset and clock control (RM0440 7.4).
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32g4 {

using stm32::Register;

struct RccRegisters {
  Register cr;       // 0x00
  Register icscr;
  Register cfgr;     // 0x08
  Register pllcfgr;  // 0x0C
  Register reserved0[2], cier, cifr, cicr, reserved1, ahb1rstr, ahb2rstr, ahb3rstr, reserved2, apb1rstr1, apb1rstr2,
      apb2rstr, reserved3, ahb1enr;
  Register ahb2enr;  // 0x4C
  Register ahb3enr, reserved4;
  Register apb1enr1;  // 0x58
  Register apb1enr2;
  Register apb2enr;  // 0x60
  Register reserved5, ahb1smenr, ahb2smenr, ahb3smenr, reserved6, apb1smenr1, apb1smenr2, apb2smenr, reserved7;
  Register ccipr;  // 0x88
  Register reserved8, bdcr;
  Register csr;  // 0x94
};
static_assert(offsetof(RccRegisters, pllcfgr) == 0x0C && offsetof(RccRegisters, ahb2enr) == 0x4C);
static_assert(offsetof(RccRegisters, apb1enr1) == 0x58 && offsetof(RccRegisters, apb2enr) == 0x60);
static_assert(offsetof(RccRegisters, ccipr) == 0x88 && offsetof(RccRegisters, csr) == 0x94);

/// The external crystal over 6, times 72, over 2: 144 MHz for the processor and all buses, within range 1 without its
/// boost (6.1.5: 150 MHz). The bus's controller runs from the crystal itself.
inline constexpr std::uint32_t kCrystal_hz = 24'000'000, kCore_hz = 144'000'000;

/// False when the crystal or the PLL does not come up, or flash does not take its wait states.
[[nodiscard]] bool start_clocks(RccRegisters& rcc, Register& flash_acr);

}  // namespace voltlap::port::stm32g4
