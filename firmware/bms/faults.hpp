// SPDX-License-Identifier: Apache-2.0
// The fault table: one row a fault with its condition, time, latch and whether it opens the contactors.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// Judges every row. A latched fault stays until the master asks for a reset with everything healthy
/// and the tractive system off (EV.7.2.3).
void judge_faults(const Config& config, Instant now, State& state);

[[nodiscard]] constexpr std::uint32_t bit_of(can::BmsFault fault) { return 1U << static_cast<unsigned>(fault); }
[[nodiscard]] constexpr bool is_set(const Faults& faults, can::BmsFault fault) {
  return (faults.bits & bit_of(fault)) != 0;
}

}  // namespace voltlap::bms
