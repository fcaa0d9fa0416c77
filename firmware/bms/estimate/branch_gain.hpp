// SPDX-License-Identifier: Apache-2.0
// How far an RC branch goes towards its end value in a time: 1 - exp(-t / tau).
#pragma once
#include <cstdint>
#include <limits>

#include "bms/estimate/cell_model.hpp"

namespace voltlap::bms {

// Shares below a half are kept in 2^-32, so that what they take of a number is the upper half of a product: one
// instruction of the processor.
inline constexpr std::int32_t kShareMost = 2'104'533'975;  // 0.49

/// The part that a share [2^-32] takes.
[[nodiscard]] constexpr std::int32_t part(std::int32_t share, std::int32_t of) {
  return static_cast<std::int32_t>((std::int64_t{share} * of + (std::int64_t{1} << 31)) >> 32);
}

/// 1 - exp(-x) [2^-32], to x^4; x at most 0.49 [2^-32].
[[nodiscard]] constexpr std::int32_t small_gain(std::int32_t x) {
  constexpr std::int32_t kThird = 1'431'655'765;
  const std::int32_t half_square = part(x, x) >> 1;
  return x - half_square + part(half_square, part(x, kThird - x / 12));  // the rest of x^2/2, taken x times
}

/// Of a step of the filter: an x beyond 0.49 counts as that.
[[nodiscard]] constexpr std::int32_t gain_of(std::int32_t rate, std::int32_t elapsed_ms) {
  const std::int64_t all = (std::int64_t{rate} * elapsed_ms) >> (kRateBits - 32);
  return small_gain(all > kShareMost ? kShareMost : static_cast<std::int32_t>(all));
}

inline constexpr int kLongGainBits = 30;

/// Of any time [2^-30]: exp(-x) is the square of exp(-x / 2), again and again.
[[nodiscard]] constexpr std::int32_t long_gain_of(std::int32_t rate, std::int32_t elapsed_ms) {
  constexpr std::int64_t kOver = std::int64_t{22} << 32;  // exp(-22) is below 2^-30
  std::int64_t x = (std::int64_t{rate} * elapsed_ms) >> (kRateBits - 32);
  if (x >= kOver) return 1 << kLongGainBits;
  int halved = 0;
  for (; x > kShareMost; x >>= 1) ++halved;
  const auto gain = static_cast<std::uint32_t>(small_gain(static_cast<std::int32_t>(x)));
  std::uint32_t left = (std::uint32_t{1} << 31) - (gain >> 1);
  for (; halved > 0; --halved) left = static_cast<std::uint32_t>((std::uint64_t{left} * left) >> 31);
  return static_cast<std::int32_t>(((std::uint32_t{1} << 31) - left) >> 1);
}

/// A rate at a time that is `factor` times as long, within 2^-12; one of less than 0.26 counts as that.
[[nodiscard]] constexpr std::int32_t slowed(std::int32_t rate, std::int32_t factor) {
  constexpr int kBits = 14;
  constexpr std::int32_t kLeast = 4'260;
  static_assert((std::int64_t{1} << kRateBits) / check::kBranchTimeMin.ms() * (1 << kBits) / kLeast <
                std::numeric_limits<std::int32_t>::max());
  const std::int32_t coarse = factor >> (kUnitBits - kBits);
  return scaled(rate, (1 << 30) / (coarse < kLeast ? kLeast : coarse), 30 - kBits);
}

}  // namespace voltlap::bms
