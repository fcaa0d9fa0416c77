// SPDX-License-Identifier: Apache-2.0
// Steps at a fixed period of the wall clock, and how late they began.
#pragma once
#include <algorithm>
#include <cstdint>

#include "port/host/wall_clock.hpp"

namespace voltlap::port {

/// What happens when a step cannot begin in time.
enum class Lag {
  kCatchUp,  ///< the next steps follow at once until the schedule is met: simulated time stays the wall's
  kForget,   ///< the schedule moves: the period is a lower bound
};

class Pacer {
 public:
  Pacer(std::int64_t period_us, Lag lag) : period_us_(period_us), lag_(lag), next_us_(clock_.now_us()) {}

  /// Waits for the time of the next step; the first is due at once. May end early when a signal comes.
  void wait() {
    if (clock_.now_us() < next_us_) clock_.sleep_until_us(next_us_);
    const std::int64_t now = clock_.now_us(), lateness = now - next_us_;
    if (lag_ == Lag::kForget) {
      next_us_ = std::max(next_us_, now) + period_us_;
      return;
    }
    worst_us_ = std::max(worst_us_, lateness);
    if (lateness > period_us_ / 2) ++late_steps_;
    next_us_ = lateness > kGiveUp_us ? now + period_us_ : next_us_ + period_us_;
  }
  /// Time until the next step may begin [us]; negative when it is overdue.
  [[nodiscard]] std::int64_t ahead_us() const { return next_us_ - clock_.now_us(); }

  [[nodiscard]] std::uint64_t late_steps() const { return late_steps_; }  ///< began more than half a period late
  [[nodiscard]] std::int64_t worst_us() const { return worst_us_; }

 private:
  static constexpr std::int64_t kGiveUp_us = 1'000'000;  // a machine that slept need not drive all of it at once

  WallClock clock_;
  std::int64_t period_us_;
  Lag lag_;
  std::int64_t next_us_;
  std::int64_t worst_us_ = 0;
  std::uint64_t late_steps_ = 0;
};

}  // namespace voltlap::port
