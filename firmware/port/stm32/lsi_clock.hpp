// SPDX-License-Identifier: Apache-2.0
// The processor's clock against the LSI, by a timer that runs with the former and captures edges of the latter: TIM5
// channel 4 of the STM32F4 (RM0090 18.4.21, TI4_RMP = 1), TIM16 channel 1 of the STM32G4 (RM0440 TIM16_TISEL = 6).
//
// What it can find follows from the datasheet's range of the LSI. With c, the clock over what it should be: a period
// that counts as an LSI beyond its range is a fault, so any LSI finds c > fastest/slowest and c < slowest/fastest.
//   STM32F4, 17 to 47 kHz: surely above 2.77 or below 0.36, of a typical LSI of 32 kHz above 1.88 or below 0.68. That
//   is a crystal of another value (25 MHz for 8 MHz: 3.1), a PLL that is not in use (16 MHz of 168: 0.095), a bus
//   divider off by four; not a crystal that drifts or one a third off.
//   STM32G4, 29.5 to 34 kHz: surely above 1.153 or below 0.868.
#pragma once
#include "port/second_clock.hpp"
#include "port/stm32/lsi_range.hpp"
#include "port/stm32/timer_registers.hpp"

namespace voltlap::port::stm32 {

class LsiClock final : public SecondClock {
 public:
  static constexpr std::uint32_t kTicksPerLook = 10;  ///< a look takes two periods of the LSI: 118 us at most
  static constexpr std::uint32_t kLooksMost = 3;      ///< bad or silent ones in a row: told after 300 ms at the latest
  static constexpr std::uint32_t kTornMost = 10;      ///< looks in a row that interrupts kept from being one

  struct Input {
    std::uint8_t channel = 0;         ///< 1 to 4
    std::uint32_t counter_mask = 0;   ///< of 16 or 32 bits
    std::uint32_t timer_hz = 0;       ///< as it should be
    LsiRange lsi{1, 1};
  };

  LsiClock(TimerRegisters& timer, const Input& input) : timer_(timer), input_(input) {}

  /// The timer's clock is on by then. `csr`: RCC_CSR, which turns the LSI on; `select`: the register that has the
  /// channel listen to the LSI when it holds `lsi`.
  /// Waits at most some ms for it; one that does not come is a look that failed, not a refusal to start.
  void start(Register& csr, Register& select, std::uint32_t lsi);

  bool agrees() override;

 private:
  enum class Look { kGood, kBad, kTorn };
  [[nodiscard]] Look look();
  [[nodiscard]] bool in_range(std::uint32_t counts) const;

  TimerRegisters& timer_;
  Input input_;
  std::uint32_t ticks_ = 0, bad_ = 0, torn_ = 0;
  bool lost_ = false;
};

}  // namespace voltlap::port::stm32
