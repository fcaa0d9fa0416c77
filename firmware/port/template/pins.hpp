// SPDX-License-Identifier: Apache-2.0
// The pins of the board, by what they mean.
#pragma once
#include "port/gpio.hpp"

namespace voltlap::port {

/// At once, without anything that must have been set up before: the last thing that a board does.
void open_relays();

class BoardPins final : public Gpio {
 public:
  /// Outputs off before they become outputs; inputs pulled to the level at which they are false.
  [[nodiscard]] bool init();
  void set(Drive what, bool on) override;
  [[nodiscard]] bool get(Sense what) const override;
};

}  // namespace voltlap::port
