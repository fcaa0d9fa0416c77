// SPDX-License-Identifier: Apache-2.0
// How long a condition has held in all, where a time without it takes back a quarter of itself: what comes and goes is
// found in the end, where it is there for more than a fifth of the time. All-zero memory has seen nothing.
#pragma once
#include <cstdint>

#include "base/time.hpp"

namespace voltlap {

class LeakyPersistence {
 public:
  /// True while `condition` holds, once it has held for `limit`; as Persistence when it never pauses.
  bool held(bool condition, Instant now, Duration limit) {
    const std::int64_t step_us = started_ ? elapsed_us(now) : 0;
    const std::int64_t limit_us = std::int64_t{limit.ms()} * 1000;
    const bool before = condition_;
    started_ = true;
    last_ = now;
    condition_ = condition;
    if (!condition) {
      level_us_ = level_us_ > step_us / kDecay ? level_us_ - step_us / kDecay : 0;
      return false;
    }
    // The step that finds it begins the count.
    if (before) level_us_ = level_us_ + step_us < limit_us ? level_us_ + step_us : limit_us;
    return level_us_ >= limit_us;
  }

 private:
  static constexpr std::int64_t kDecay = 4;  ///< counts down so many times slower than up

  [[nodiscard]] std::int64_t elapsed_us(Instant now) const {
    const std::int32_t ms = (now - last_).ms();
    return ms > 0 ? std::int64_t{ms} * 1000 : 0;
  }

  std::int64_t level_us_ = 0;
  Instant last_{};
  bool started_ = false;
  bool condition_ = false;
};

}  // namespace voltlap
