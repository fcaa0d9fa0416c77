// SPDX-License-Identifier: Apache-2.0
// The seam to a second oscillator, which the processor's clock is compared with: every time of a node, its timeouts and
// its count of charge, is a number of ticks of that clock. A port without a second oscillator has none of this
// (Board::second_clock is nullptr), and nothing is compared.
#pragma once

namespace voltlap::port {

class SecondClock {
 public:
  /// Once a tick. False when the processor's clock is beyond the bound of the comparison or the second oscillator
  /// stands, told several times in a row; for good.
  [[nodiscard]] virtual bool agrees() = 0;

 protected:
  ~SecondClock() = default;
};

}  // namespace voltlap::port
