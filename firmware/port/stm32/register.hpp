// SPDX-License-Identifier: Apache-2.0
// A 32-bit register of a peripheral. Every access is a call into register.cpp, some six cycles of a Cortex-M4: the
// tests link another one in its place, whose registers behave as the reference manual says. So drivers are plain
// classes, and the very objects that were tested go onto the part.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port::stm32 {

class Register {
 public:
  [[nodiscard]] std::uint32_t read() const;
  void write(std::uint32_t value);

  void set(std::uint32_t bits) { write(read() | bits); }
  void clear(std::uint32_t bits) { write(read() & ~bits); }
  void replace(std::uint32_t mask, std::uint32_t bits) { write((read() & ~mask) | bits); }

 private:
  volatile std::uint32_t word_ = 0;
};
static_assert(sizeof(Register) == 4 && alignof(Register) == 4, "as the peripherals lay them out");

/// A hand-shake that has not come after this many reads never will: at least 8 cycles each, so 9 ms and more at
/// 168 MHz, where the slowest of CAN (a frame on the bus at 125 kbit/s and 11 recessive bits) takes 1.2 ms.
inline constexpr std::uint32_t kHandshakeReads = 200'000;

/// Waits until all `bits` read as set, or as clear; false when they do not.
[[nodiscard]] inline bool wait_set(const Register& r, std::uint32_t bits, std::uint32_t reads = kHandshakeReads) {
  for (std::uint32_t i = 0; i < reads; ++i) {
    if ((r.read() & bits) == bits) return true;
  }
  return false;
}
[[nodiscard]] inline bool wait_clear(const Register& r, std::uint32_t bits, std::uint32_t reads = kHandshakeReads) {
  for (std::uint32_t i = 0; i < reads; ++i) {
    if ((r.read() & bits) == 0) return true;
  }
  return false;
}

/// Until the next interrupt (the instruction WFI); beside the registers, because the tests need another one of it too.
void wait_for_interrupt();

}  // namespace voltlap::port::stm32
