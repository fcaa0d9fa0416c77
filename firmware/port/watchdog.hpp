// SPDX-License-Identifier: Apache-2.0
// The seam to the watchdog: a counter with a clock of its own that resets the board when it is not fed. Outputs fall
// off with the reset, and the contactors open.
#pragma once
#include "base/time.hpp"

namespace voltlap::port {

class Watchdog {
 public:
  /// Starts it; it cannot be stopped. False when it does not answer or cannot be made to bite within `timeout`, whose
  /// tolerance is that of its clock.
  virtual bool start(Duration timeout) = 0;
  /// Once, at the end of every tick that did all of its work; nowhere else.
  virtual void feed() = 0;
  /// The last reset was its doing; stays true until the next power-on or until it is told apart by the port.
  [[nodiscard]] virtual bool has_bitten() const = 0;

 protected:
  ~Watchdog() = default;
};

}  // namespace voltlap::port
