// SPDX-License-Identifier: Apache-2.0
// Time as an argument: points (Instant) and differences (Duration) are different types; nothing here reads a clock.
#pragma once
#include <cstdint>

namespace voltlap {

/// A span of time in milliseconds.
class Duration {
 public:
  constexpr Duration() = default;
  [[nodiscard]] static constexpr Duration from_ms(std::int32_t ms) { return Duration(ms); }
  [[nodiscard]] constexpr std::int32_t ms() const { return ms_; }
  friend constexpr bool operator<(Duration a, Duration b) { return a.ms_ < b.ms_; }
  friend constexpr bool operator<=(Duration a, Duration b) { return a.ms_ <= b.ms_; }
  friend constexpr bool operator>(Duration a, Duration b) { return a.ms_ > b.ms_; }
  friend constexpr bool operator>=(Duration a, Duration b) { return a.ms_ >= b.ms_; }
  friend constexpr bool operator==(Duration a, Duration b) { return a.ms_ == b.ms_; }

 private:
  constexpr explicit Duration(std::int32_t ms) : ms_(ms) {}
  std::int32_t ms_ = 0;
};

/// A point in time, milliseconds since the node started; wraps after 49 days, and differences stay right across it.
class Instant {
 public:
  constexpr Instant() = default;
  [[nodiscard]] static constexpr Instant from_ms(std::uint32_t ms) { return Instant(ms); }
  [[nodiscard]] constexpr std::uint32_t ms() const { return ms_; }
  /// Later minus earlier; negative when `b` is the later one.
  friend constexpr Duration operator-(Instant a, Instant b) {
    return Duration::from_ms(static_cast<std::int32_t>(a.ms_ - b.ms_));
  }
  friend constexpr Instant operator+(Instant a, Duration d) {
    return Instant(a.ms_ + static_cast<std::uint32_t>(d.ms()));
  }

 private:
  constexpr explicit Instant(std::uint32_t ms) : ms_(ms) {}
  std::uint32_t ms_ = 0;
};

}  // namespace voltlap
