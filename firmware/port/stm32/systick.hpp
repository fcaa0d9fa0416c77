// SPDX-License-Identifier: Apache-2.0
// The clock behind the system timer of every Cortex-M (ARMv7-M architecture reference manual, DDI 0403, B3.3): one
// interrupt a millisecond, counted. Its handler SysTick_Handler calls on_interrupt.
#pragma once
#include "port/clock.hpp"
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {

struct SysTickRegisters {  // at 0xE000 E010
  Register csr;    // SYST_CSR
  Register rvr;    // SYST_RVR reload
  Register cvr;    // SYST_CVR current; any write clears it
  Register calib;  // SYST_CALIB
};
static_assert(offsetof(SysTickRegisters, calib) == 0x0C);

class SysTick final : public Clock {
 public:
  explicit SysTick(SysTickRegisters& registers) : regs_(registers) {}

  /// `clock_hz` of the processor: a whole number of kHz, at most 16.7 GHz. False when it is not.
  [[nodiscard]] bool start(std::uint32_t clock_hz);
  void on_interrupt();

  [[nodiscard]] Instant now() const override;
  /// Sleeps between interrupts; any of them wakes it, and it looks again.
  void sleep_until(Instant at) override;

 private:
  SysTickRegisters& regs_;
  std::uint32_t ms_ = 0;
};

}  // namespace voltlap::port::stm32
