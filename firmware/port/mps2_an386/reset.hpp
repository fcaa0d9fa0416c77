// SPDX-License-Identifier: Apache-2.0
// A reset that the processor asks for itself. The emulator leaves the memory as it is; reset() begins as after
// power-on.
#pragma once
#include <cstdint>

namespace voltlap::port {

[[noreturn]] inline void reset_processor() {
  /// Application interrupt and reset control register (ARMv7-M Architecture Reference Manual, B3.2.6).
  constexpr std::uint32_t kAircr = 0xE000'ED0CU, kKey = 0x05FA'0000U, kReset = 1U << 2;
  asm volatile("dsb" : : : "memory");
  for (;;) *reinterpret_cast<volatile std::uint32_t*>(kAircr) = kKey | kReset;
}

}  // namespace voltlap::port
