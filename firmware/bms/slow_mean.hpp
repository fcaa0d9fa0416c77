// SPDX-License-Identifier: Apache-2.0
// Means that forget, in integers: m += (x - m) dt / (tau + dt), the share in 1/65536.
#pragma once
#include <cstdint>

#include "base/time.hpp"

namespace voltlap::bms {

/// Share of the new value after `elapsed` with time constant `tau`, in 1/65536; 0 for a time that runs back.
[[nodiscard]] constexpr std::int64_t share_of(Duration elapsed, Duration tau) {
  const std::int64_t dt = elapsed.ms() < 0 ? 0 : elapsed.ms();
  return dt * 65'536 / (tau.ms() + dt);
}

/// The share that was last asked for: nearly all gaps are alike, and a division is dear.
struct LastShare {
  Duration elapsed{}, tau{};
  std::int64_t share = 0;
};

[[nodiscard]] constexpr std::int64_t share_of(Duration elapsed, Duration tau, LastShare& last) {
  if (!(last.elapsed == elapsed && last.tau == tau)) last = LastShare{elapsed, tau, share_of(elapsed, tau)};
  return last.share;
}

/// `share` of share_of. |x - mean| stays below 2^47: its product with the share fits.
[[nodiscard]] constexpr std::int64_t follow(std::int64_t mean, std::int64_t x, std::int64_t share) {
  return mean + (x - mean) * share / 65'536;
}

/// The same where |x - mean| stays below 2^31: one multiplication, for what is done for every cell.
[[nodiscard]] constexpr std::int32_t follow_near(std::int32_t mean, std::int32_t x, std::int32_t share) {
  return mean + static_cast<std::int32_t>(std::int64_t{x - mean} * share / 65'536);
}

}  // namespace voltlap::bms
