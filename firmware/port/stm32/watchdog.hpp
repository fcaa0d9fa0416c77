// SPDX-License-Identifier: Apache-2.0
// The independent watchdog (IWDG) of the STM32: RM0090 chapter 21, RM0440 "Independent watchdog (IWDG)". It counts an
// RC oscillator of its own (LSI), so it bites when the main clock stops, too.
#pragma once
#include "port/stm32/lsi_range.hpp"
#include "port/stm32/register.hpp"
#include "port/watchdog.hpp"

namespace voltlap::port::stm32 {

struct IwdgRegisters {
  Register kr;   // 0x00 key
  Register pr;   // 0x04 prescaler
  Register rlr;  // 0x08 reload
  Register sr;   // 0x0C PVU, RVU
};
static_assert(offsetof(IwdgRegisters, sr) == 0x0C);

class Iwdg final : public Watchdog {
 public:
  /// `reset_flags`: RCC_CSR, whose bit 29 (IWDGRSTF) says that it has bitten, and whose RMVF clears that.
  /// `remove_flags`: RMVF there, bit 24 of the STM32F4 and bit 23 of the STM32G4.
  Iwdg(IwdgRegisters& registers, Register& reset_flags, std::uint32_t remove_flags, LsiRange lsi)
      : regs_(registers), reset_flags_(reset_flags), remove_flags_(remove_flags), lsi_(lsi) {}

  /// It bites at `timeout` at the latest, with the slowest oscillator; with the fastest sooner, see earliest_bite.
  /// False: longer than 4096 counts of the longest prescaler or shorter than one, or it does not take its settings.
  bool start(Duration timeout) override;
  void feed() override;
  [[nodiscard]] bool has_bitten() const override;
  /// Once a start has told why it started.
  void forget_bite();

  /// The soonest that a watchdog started with `timeout` bites.
  [[nodiscard]] Duration earliest_bite(Duration timeout) const;

 private:
  struct Counts {
    std::uint32_t prescaler_code = 0;
    std::uint32_t counts = 0;  ///< 0: there is none
  };
  [[nodiscard]] Counts counts_for(Duration timeout) const;

  IwdgRegisters& regs_;
  Register& reset_flags_;
  std::uint32_t remove_flags_;
  LsiRange lsi_;
};

}  // namespace voltlap::port::stm32
