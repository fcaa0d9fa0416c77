// SPDX-License-Identifier: Apache-2.0
// The wall's clock: monotonic, counted from when it was made.
#pragma once
#include <cerrno>
#include <cstdint>
#include <ctime>

#include "port/clock.hpp"

namespace voltlap::port {

class WallClock final : public Clock {
 public:
  WallClock() { ::clock_gettime(CLOCK_MONOTONIC, &start_); }

  [[nodiscard]] std::int64_t now_us() const {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return (now.tv_sec - start_.tv_sec) * std::int64_t{1'000'000} + (now.tv_nsec - start_.tv_nsec) / 1000;
  }
  /// Ends early when a signal comes.
  void sleep_until_us(std::int64_t at_us) const {
    timespec at = start_;
    at.tv_sec += at_us / 1'000'000;
    at.tv_nsec += at_us % 1'000'000 * 1000;
    if (at.tv_nsec >= 1'000'000'000) {
      ++at.tv_sec;
      at.tv_nsec -= 1'000'000'000;
    }
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
  }

  [[nodiscard]] Instant now() const override { return Instant::from_ms(static_cast<std::uint32_t>(now_us() / 1000)); }
  void sleep_until(Instant at) override { sleep_until_us(std::int64_t{at.ms()} * 1000); }

 private:
  timespec start_{};
};

}  // namespace voltlap::port
