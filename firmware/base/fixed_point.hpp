// SPDX-License-Identifier: Apache-2.0
// Products of fixed-point numbers: rounded to nearest, saturated at the ends of 32 bits.
#pragma once
#include <cstdint>
#include <limits>

namespace voltlap {

[[nodiscard]] constexpr std::int32_t saturated32(std::int64_t value) {
  constexpr std::int64_t low = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t high = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(value < low ? low : (value > high ? high : value));
}

/// value / 2^shift to the nearest, halves upwards; 1 <= shift <= 61, |value| < 2^62.
[[nodiscard]] constexpr std::int64_t shifted(std::int64_t value, int shift) {
  return (value + (std::int64_t{1} << (shift - 1))) >> shift;
}

/// a b / 2^shift. Two numbers of 32 bits never overflow the product; -2^31 squared is 2^62, the largest.
[[nodiscard]] constexpr std::int32_t product(std::int32_t a, std::int32_t b, int shift) {
  return saturated32(shifted(std::int64_t{a} * b, shift));
}

/// a b / 2^shift, rounded down, where the caller knows that it fits; a third of the instructions.
[[nodiscard]] constexpr std::int32_t scaled(std::int32_t a, std::int32_t b, int shift) {
  return static_cast<std::int32_t>((std::int64_t{a} * b) >> shift);
}

}  // namespace voltlap
