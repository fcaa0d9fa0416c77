// SPDX-License-Identifier: Apache-2.0
// What a board of the STM32F4 needs to come up: reset and clock control (RM0090 chapter 7), the interrupt controller
// and the system control block (ARMv7-M architecture reference manual B3.2, B3.4).
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32f4 {

using stm32::Register;

struct RccRegisters {
  Register cr;       // 0x00
  Register pllcfgr;  // 0x04
  Register cfgr;     // 0x08
  Register cir, ahb1rstr, ahb2rstr, ahb3rstr, reserved0, apb1rstr, apb2rstr, reserved1[2];
  Register ahb1enr;  // 0x30
  Register ahb2enr, ahb3enr, reserved2;
  Register apb1enr;  // 0x40
  Register apb2enr, reserved3[2];
  Register ahb1lpenr, ahb2lpenr, ahb3lpenr, reserved4, apb1lpenr, apb2lpenr, reserved5[2];
  Register bdcr;  // 0x70
  Register csr;   // 0x74
};
static_assert(offsetof(RccRegisters, ahb1enr) == 0x30 && offsetof(RccRegisters, apb1enr) == 0x40);
static_assert(offsetof(RccRegisters, bdcr) == 0x70 && offsetof(RccRegisters, csr) == 0x74);

/// The external crystal times 336 over 8 and 2: 168 MHz, APB1 at 42 MHz, APB2 at 84 MHz (7.2, 7.3.2; flash 3.5.1).
inline constexpr std::uint32_t kCrystal_hz = 8'000'000, kCore_hz = 168'000'000, kApb1_hz = 42'000'000;

/// False when the crystal or the PLL does not come up: the bus needs the crystal, the internal oscillator is too
/// coarse.
[[nodiscard]] bool start_clocks(RccRegisters& rcc, Register& flash_acr);

}  // namespace voltlap::port::stm32f4
