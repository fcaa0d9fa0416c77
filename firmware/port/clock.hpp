// SPDX-License-Identifier: Apache-2.0
// The seam between a node's loop and time. Only a port reads a clock; the logic is handed the instant of its step.
#pragma once
#include "base/time.hpp"

namespace voltlap::port {

class Clock {
 public:
  /// Time since the clock was made.
  [[nodiscard]] virtual Instant now() const = 0;
  /// Waits until `at`; returns at once when that has passed.
  virtual void sleep_until(Instant at) = 0;

 protected:
  ~Clock() = default;
};

}  // namespace voltlap::port
