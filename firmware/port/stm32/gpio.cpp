// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/gpio.hpp"

namespace voltlap::port::stm32 {
namespace {

constexpr std::uint8_t kPinsPerPort = 16;
constexpr std::uint32_t kInput = 0, kOutput = 1, kPullUp = 1, kPullDown = 2;

const Pin& pin_of(const Pins& pins, std::size_t i) { return i < kDrives ? pins.drive[i] : pins.sense[i - kDrives]; }

bool lawful(const Pins& pins) {
  for (std::size_t i = 0; i < kDrives + kSenses; ++i) {
    const Pin& a = pin_of(pins, i);
    if (a.port == nullptr) continue;
    if (a.number >= kPinsPerPort) return false;
    for (std::size_t k = 0; k < i; ++k) {
      const Pin& b = pin_of(pins, k);
      if (b.port == a.port && b.number == a.number) return false;
    }
  }
  return true;
}

void drive(const Pin& pin, bool on) {
  const bool high = on != pin.active_low;
  pin.port->bsrr.write(1U << (pin.number + (high ? 0U : unsigned{kPinsPerPort})));
}

void set_pair(Register& r, std::uint8_t number, std::uint32_t value) {
  r.replace(3U << (2U * number), value << (2U * number));
}

}  // namespace

bool BoardPins::init() {
  if (!lawful(pins_)) return false;
  for (const Pin& pin : pins_.drive) {
    if (pin.port == nullptr) continue;
    drive(pin, false);  // before it becomes an output: it never passes through on
    pin.port->otyper.clear(1U << pin.number);
    set_pair(pin.port->moder, pin.number, kOutput);
  }
  for (const Pin& pin : pins_.sense) {
    if (pin.port == nullptr) continue;
    set_pair(pin.port->pupdr, pin.number, pin.active_low ? kPullUp : kPullDown);
    set_pair(pin.port->moder, pin.number, kInput);
  }
  return true;
}

void BoardPins::set(Drive what, bool on) {
  const Pin& pin = pins_.drive[static_cast<std::size_t>(what)];
  if (pin.port != nullptr) drive(pin, on);
}

bool BoardPins::get(Sense what) const {
  const Pin& pin = pins_.sense[static_cast<std::size_t>(what)];
  if (pin.port == nullptr) return false;
  const bool high = (pin.port->idr.read() >> pin.number & 1U) != 0;
  return high != pin.active_low;
}

}  // namespace voltlap::port::stm32
