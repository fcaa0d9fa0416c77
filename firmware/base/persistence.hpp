// SPDX-License-Identifier: Apache-2.0
// How long a condition has held without a break. All-zero memory is "not holding".
#pragma once
#include "base/time.hpp"

namespace voltlap {

class Persistence {
 public:
  /// True once `condition` has held at every call for at least `limit`; false again at the first call without it.
  bool held(bool condition, Instant now, Duration limit) {
    if (!condition) {
      *this = Persistence{};
      return false;
    }
    if (!running_) {
      running_ = true;
      since_ = now;
    }
    // Kept, so that a condition that holds for longer than half the clock's range is not forgotten at the wrap.
    tripped_ = tripped_ || now - since_ >= limit;
    return tripped_;
  }

 private:
  Instant since_{};
  bool running_ = false;
  bool tripped_ = false;
};

}  // namespace voltlap
