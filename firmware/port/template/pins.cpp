// SPDX-License-Identifier: Apache-2.0
#include "port/template/pins.hpp"

namespace voltlap::port {

/// FILL 3: reset the outputs of the relays.
void open_relays() {}

/// FILL 3: port/stm32/gpio.hpp does it for every STM32 with its kind of port, from a table of pins.
bool BoardPins::init() {
  open_relays();
  return true;
}

void BoardPins::set(Drive /*what*/, bool /*on*/) {}

/// False is the state that opens: a circuit that is not sensed is not closed.
bool BoardPins::get(Sense /*what*/) const { return false; }

}  // namespace voltlap::port
