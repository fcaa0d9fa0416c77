// SPDX-License-Identifier: Apache-2.0
// The timer of a fault. It counts up while the condition lasts and down at a quarter of the pace when it has gone, so
// that a fault which comes and goes trips in the end: one that is there for more than a fifth of the time. One good
// sample never clears it, an invalid one never resets it.
#pragma once
#include <cstdint>

#include "base/time.hpp"

namespace voltlap::bms {

enum class Seen : std::uint8_t {
  kUnknown = 0,  ///< no sample: what was last known goes on
  kClear = 1,
  kActive = 2,
  kHold = 3,     ///< nothing can be said now: the timer stands
};

struct FaultTimer {
  std::int32_t level_us = 0;  ///< [us] at most the fault's time
  bool active = false;        ///< as last known
  bool set = false;
};

/// A clear condition changes nothing in it: what is set is active or has counted.
[[nodiscard]] constexpr bool idle(const FaultTimer& timer) { return timer.level_us == 0 && !timer.active; }

inline constexpr std::int32_t kFaultDecay = 4;        ///< counts down so many times slower than up
inline constexpr Duration kFaultTimeMax = Duration::from_ms(600'000);  ///< of a fault; keeps the level inside 32 bits

/// One step of `elapsed`. The fault is set from `time` of the condition on, in the step that finds it for a time of 0.
constexpr void count(Seen condition, Duration elapsed, Duration time, FaultTimer& timer) {
  const std::int32_t most_us = time.ms() * 1000;
  const std::int64_t step_us = std::int64_t{elapsed.ms() < 0 ? 0 : elapsed.ms()} * 1000;
  const bool was_active = timer.active;
  if (condition == Seen::kHold || (condition == Seen::kUnknown && !was_active)) return;
  if (condition != Seen::kUnknown) timer.active = condition == Seen::kActive;
  if (timer.active) {
    // The step that finds it begins the count.
    const std::int64_t level = was_active ? timer.level_us + step_us : timer.level_us;
    timer.level_us = static_cast<std::int32_t>(level < most_us ? level : most_us);
  } else {
    const std::int64_t level = timer.level_us - step_us / kFaultDecay;
    timer.level_us = static_cast<std::int32_t>(level > 0 ? level : 0);
  }
  timer.set = timer.active ? timer.level_us >= most_us : (timer.set && time > Duration{} && timer.level_us > 0);
}

}  // namespace voltlap::bms
