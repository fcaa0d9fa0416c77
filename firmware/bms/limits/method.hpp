// SPDX-License-Identifier: Apache-2.0
// What every method of the limits is given and does: it lowers a limit that something else has set, and says why.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// The lower of two limits with its reason.
inline void lower(Limit& limit, Current value, can::LimitReason reason, std::uint8_t cell = kNoCell) {
  if (value < limit.value) limit = Limit{max(value, Current{}), reason, cell};
}

/// `full` scaled by numerator / denominator, both not negative, rounded down.
inline Current share_of_limit(Current full, std::int64_t numerator, std::int64_t denominator) {
  if (numerator <= 0) return Current{};
  if (numerator >= denominator) return full;
  return Current::saturated(std::int64_t{full.raw()} * numerator / denominator);
}

}  // namespace voltlap::bms
