// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {

std::uint32_t Register::read() const { return word_; }
void Register::write(std::uint32_t value) { word_ = value; }

void wait_for_interrupt() { __asm__ volatile("wfi" ::: "memory"); }

}  // namespace voltlap::port::stm32
