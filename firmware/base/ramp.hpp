// SPDX-License-Identifier: Apache-2.0
// How a limit moves: it falls at once and rises slowly.
//   y = min(target, y_before + rate dt), in whole units of Q, the rise rounded towards zero
#pragma once
#include <cstdint>

#include "base/require.hpp"
#include "base/time.hpp"

namespace voltlap {

/// Q is a quantity of base/units.hpp. A rise beyond the range of Q saturates.
template <class Q>
struct Ramp {
  Q rise_per_s{};

  /// Where a limit that stood at `before` is after `elapsed`, not negative. Equal to `target` once it is there.
  [[nodiscard]] constexpr Q toward(Q target, Q before, Duration elapsed) const {
    VOLTLAP_REQUIRE(elapsed >= Duration{});
    const std::int64_t rise = std::int64_t{rise_per_s.raw()} * elapsed.ms() / 1'000;
    const Q reachable = Q::saturated(before.raw() + rise);
    return target <= reachable ? target : reachable;
  }
};

}  // namespace voltlap
