// SPDX-License-Identifier: Apache-2.0
// The low-voltage supply of a control unit.
#pragma once
#include <optional>

#include "base/time.hpp"

namespace voltlap::plant {

/// Dead for good, or off until then. `fresh`: it has come back, and the unit has not started on it yet.
struct Supply {
  bool dead = false, fresh = true;
  std::optional<Instant> back{};

  [[nodiscard]] bool on(Instant now) {
    if (dead || (back && now - *back < Duration{})) return false;
    back.reset();
    return true;
  }
  void fail(Instant now, Duration off) {
    fresh = true;
    back = now + off;
  }
};

}  // namespace voltlap::plant
