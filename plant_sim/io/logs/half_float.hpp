// SPDX-License-Identifier: Apache-2.0
// IEEE 754 binary16: 1 bit sign, 5 bits exponent (bias 15), 10 bits fraction.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>

namespace voltlap::plant {

[[nodiscard]] inline double half_float(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1F, fraction = bits & 0x3FF;
  double size = 0.0;
  if (exponent == 0x1F) {
    size = fraction == 0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  } else if (exponent == 0) {
    size = std::ldexp(fraction, -24);
  } else {
    size = std::ldexp(0x400 + fraction, exponent - 25);
  }
  return (bits & 0x8000) != 0 ? -size : size;
}

}  // namespace voltlap::plant
