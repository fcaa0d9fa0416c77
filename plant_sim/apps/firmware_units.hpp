// SPDX-License-Identifier: Apache-2.0
// SI to the nearest of the firmware's integers.
#pragma once
#include <cmath>
#include <cstdint>

#include "base/units.hpp"

namespace voltlap::plant {

/// Held within the quantity's range.
template <class Quantity>
[[nodiscard]] Quantity units(double si, double per_si) {
  return Quantity::saturated(static_cast<std::int64_t>(std::llround(si * per_si)));
}

[[nodiscard]] inline Temperature celsius(double t) { return units<Temperature>(t, 10.0); }

}  // namespace voltlap::plant
