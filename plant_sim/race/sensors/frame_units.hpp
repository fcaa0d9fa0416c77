// SPDX-License-Identifier: Apache-2.0
// What every sender of the plant needs: SI to the codec's integers, and whether a message's turn has come.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/time.hpp"
#include "can_dbc/tables.hpp"
#include "codec/message_table.hpp"

namespace voltlap::plant {

/// To nearest, saturated at 2e9.
[[nodiscard]] inline std::int32_t to_units(double value, double units_per_si) {
  return static_cast<std::int32_t>(std::lround(std::clamp(value * units_per_si, -2e9, 2e9)));
}

/// By the cycle and the delay that the DBC gives it.
[[nodiscard]] inline bool row_due(std::uint32_t id, Instant now) {
  const auto& row = can::kMessages[codec::find_row(can::kMessages, codec::kMessageCount, id)];
  return can::due(now.ms(), row.cycle_ms, row.delay_ms);
}

}  // namespace voltlap::plant
