// SPDX-License-Identifier: Apache-2.0
// How much of what a voltage does a current explains: means that forget, of two signals and of their products.
//   x, z: less their means before the sample, so that nothing large is taken off something large
//   explained: E = cov(x, z)^2 / cov(x, x), what is left of cov(z, z) when x is all there is
#pragma once
#include <cstdint>

#include "bms/slow_mean.hpp"

namespace voltlap::bms {

struct Covariance {
  std::int32_t x_mean = 0;  ///< [mA]
  std::int32_t z_mean = 0;  ///< [0.1 mV]
  std::int64_t xx = 0;      ///< [mA^2]
  std::int64_t xz = 0;      ///< [mA 0.1 mV]
  std::int64_t zz = 0;      ///< [(0.1 mV)^2 / 256]
};

/// |x| below 4 kA and |z| below 3 kV: xx and xz stay inside 2^47, as follow asks.
constexpr void take(std::int32_t x, std::int32_t z, std::int32_t share, Covariance& c) {
  const std::int32_t dx = x - c.x_mean, dz = z - c.z_mean, dz16 = dz / 16;
  c.x_mean = follow_near(c.x_mean, x, share);
  c.z_mean = follow_near(c.z_mean, z, share);
  c.xx = follow(c.xx, std::int64_t{dx} * dx, share);
  c.xz = follow(c.xz, std::int64_t{dx} * dz, share);
  c.zz = follow(c.zz, std::int64_t{dz16} * dz16, share);
}

inline constexpr std::int64_t kLeastSquare = 500 * 500;  // [mA^2] below it the roundings of the means show
inline constexpr std::int64_t kExplainedShare = 4;       // a quarter of what the voltage does; chosen

/// E is at least `least` squared [0.1 mV], and a quarter of cov(z, z). `sag`: -cov(x, z), or cov(x, z) for a rise; only
/// a positive one explains anything.
[[nodiscard]] constexpr bool explains(const Covariance& c, std::int64_t sag, std::int64_t least) {
  constexpr std::int64_t kMost = 10'000'000;  // [0.1 mV / A] keeps the product inside 64 bits: a pack of 1000 ohm
  if (sag <= 0) return false;
  const std::int64_t slope = sag * 1'000 / (c.xx > kLeastSquare ? c.xx : kLeastSquare);
  const std::int64_t square = (slope < kMost ? slope : kMost) * (sag / 256) / 1'000;  // as zz
  return square >= least * least / 256 && square >= c.zz / kExplainedShare;
}

}  // namespace voltlap::bms
