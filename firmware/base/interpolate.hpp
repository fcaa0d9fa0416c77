// SPDX-License-Identifier: Apache-2.0
// Linear interpolation between the points of a curve, in integers.
//   y(x) = y_i + (y_{i+1} - y_i) (x - x_i) / (x_{i+1} - x_i), rounded to nearest, held constant beyond both ends
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/require.hpp"

namespace voltlap {

template <class X>
[[nodiscard]] constexpr bool strictly_increasing(const X* x, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) {
    if (!(x[i - 1] < x[i])) return false;
  }
  return true;
}

/// numerator / denominator to the nearest integer, halves away from zero; denominator > 0.
[[nodiscard]] constexpr std::int64_t divide_rounded(std::int64_t numerator, std::int64_t denominator) {
  const std::int64_t half = denominator / 2;
  return (numerator >= 0 ? numerator + half : numerator - half) / denominator;
}

/// `x` strictly increasing, `count` at least 1. X and Y are quantities of base/units.hpp.
template <class X, class Y>
[[nodiscard]] constexpr Y interpolate(const X* x, const Y* y, std::size_t count, X at) {
  VOLTLAP_REQUIRE(count > 0);
  if (at <= x[0]) return y[0];
  if (x[count - 1] < at) return y[count - 1];
  std::size_t left = 0, right = count - 1;  // x[left] < at <= x[right]
  while (left + 1 < right) {
    const std::size_t middle = (left + right) / 2;
    (x[middle] < at ? left : right) = middle;
  }
  const std::int64_t run = std::int64_t{x[right].raw()} - x[right - 1].raw();
  const std::int64_t rise = std::int64_t{y[right].raw()} - y[right - 1].raw();
  const std::int64_t along = std::int64_t{at.raw()} - x[right - 1].raw();
  VOLTLAP_REQUIRE(run > 0);
  return Y::saturated(y[right - 1].raw() + divide_rounded(rise * along, run));
}

}  // namespace voltlap
