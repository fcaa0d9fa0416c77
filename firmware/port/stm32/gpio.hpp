// SPDX-License-Identifier: Apache-2.0
// Pins of the STM32 behind the gpio seam: RM0090 chapter 8, RM0440 chapter 9 (the same block). Which pin is what, and
// whether it is on when high, is a table of the board.
#pragma once
#include "port/gpio.hpp"
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {

struct GpioRegisters {
  Register moder;    // 0x00 two bits a pin: 0 input, 1 output
  Register otyper;   // 0x04 a bit a pin: 0 push-pull
  Register ospeedr;  // 0x08
  Register pupdr;    // 0x0C two bits a pin: 1 up, 2 down
  Register idr;      // 0x10
  Register odr;      // 0x14
  Register bsrr;     // 0x18 low half sets, high half resets: no read-modify-write, so an interrupt may use the port too
  Register lckr, afr[2];
};
static_assert(offsetof(GpioRegisters, bsrr) == 0x18 && offsetof(GpioRegisters, afr) == 0x20);

struct Pin {
  GpioRegisters* port = nullptr;  ///< nullptr: this board has none
  std::uint8_t number = 0;        ///< 0 to 15
  bool active_low = false;
};

struct Pins {
  Pin drive[kDrives] = {};
  Pin sense[kSenses] = {};
};

class BoardPins final : public Gpio {
 public:
  explicit BoardPins(const Pins& pins) : pins_(pins) {}

  /// Every drive off, then outputs; every sense an input pulled to the level at which it is false, so that a wire that
  /// is off reads as what opens. The clocks of the ports are on by then. False when a pin is named twice or its number
  /// is beyond 15; nothing is driven then.
  [[nodiscard]] bool init();

  void set(Drive what, bool on) override;
  [[nodiscard]] bool get(Sense what) const override;

 private:
  Pins pins_;
};

}  // namespace voltlap::port::stm32
