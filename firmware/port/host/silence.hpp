// SPDX-License-Identifier: Apache-2.0
// How long nobody has been heard. The clock is read only when a wait was in vain: a node that has its turn every time
// pays nothing for it.
#pragma once
#include <chrono>

namespace voltlap::port {

class Silence {
 public:
  using Clock = std::chrono::steady_clock;

  void end() { lasts_ = false; }
  /// A wait was in vain: the time since the first one that was [s].
  double go_on() {
    const auto now = Clock::now();
    if (!lasts_) since_ = now;
    lasts_ = true;
    return std::chrono::duration<double>(now - since_).count();
  }

 private:
  Clock::time_point since_{};
  bool lasts_ = false;
};

}  // namespace voltlap::port
