// SPDX-License-Identifier: Apache-2.0
// How long nobody has been heard. The clock is read only when a wait was in vain: a node that has its turn every time
// pays nothing for it.
#pragma once
#include <chrono>
#include <optional>

namespace voltlap::port {

class Silence {
 public:
  using Clock = std::chrono::steady_clock;

  void end() { since_.reset(); }
  /// A wait was in vain: the time since the first one that was [s].
  double go_on() {
    const auto now = Clock::now();
    if (!since_) since_ = now;
    return std::chrono::duration<double>(now - *since_).count();
  }

 private:
  std::optional<Clock::time_point> since_;
};

}  // namespace voltlap::port
