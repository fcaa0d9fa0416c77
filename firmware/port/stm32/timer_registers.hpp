// SPDX-License-Identifier: Apache-2.0
// A general-purpose timer of the STM32, as far as both parts have it alike: RM0090 18.4, RM0440 "TIM16 registers".
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {

struct TimerRegisters {
  Register cr1;  // 0x00
  Register cr2, smcr, dier;
  Register sr;   // 0x10 flags, cleared by zeros
  Register egr;
  Register ccmr[2];  // 0x18 channels 1 and 2, 3 and 4
  Register ccer;     // 0x20
  Register cnt;
  Register psc;  // 0x28
  Register arr;  // 0x2C
  Register rcr;
  Register ccr[4];  // 0x34; a read of a captured one clears its flag
  Register bdtr, dcr, dmar;
  Register option;  // 0x50 of the STM32F4: what channel 4 of TIM5 listens to
  Register reserved[2];
  Register tisel;  // 0x5C of the STM32G4: what each channel listens to
};
static_assert(offsetof(TimerRegisters, sr) == 0x10 && offsetof(TimerRegisters, ccmr) == 0x18);
static_assert(offsetof(TimerRegisters, arr) == 0x2C && offsetof(TimerRegisters, ccr) == 0x34);
static_assert(offsetof(TimerRegisters, option) == 0x50 && offsetof(TimerRegisters, tisel) == 0x5C);

}  // namespace voltlap::port::stm32
