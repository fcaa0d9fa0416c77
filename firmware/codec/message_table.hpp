// SPDX-License-Identifier: Apache-2.0
// Finding the row of a frame in a generated message table.
#pragma once
#include <cstddef>
#include <cstdint>

#include "can_dbc/tables.hpp"

namespace voltlap::codec {

inline constexpr std::size_t kNoRow = static_cast<std::size_t>(-1);

template <std::size_t N>
[[nodiscard]] constexpr std::size_t row_count(const can::MessageRow (&)[N]) {
  return N;
}

template <std::size_t N>
[[nodiscard]] constexpr bool sorted_by_id(const can::MessageRow (&rows)[N]) {
  for (std::size_t i = 1; i < N; ++i) {
    if (rows[i - 1].id >= rows[i].id) return false;
  }
  return true;
}

/// Index of the row with this identifier, kNoRow when there is none; the table is sorted by identifier.
[[nodiscard]] constexpr std::size_t find_row(const can::MessageRow* rows, std::size_t count, std::uint32_t id) {
  std::size_t low = 0;
  std::size_t high = count;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (rows[middle].id < id) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < count && rows[low].id == id ? low : kNoRow;
}

inline constexpr std::size_t kMessageCount = row_count(can::kMessages);
static_assert(sorted_by_id(can::kMessages));
static_assert(sorted_by_id(can::kBmsRx) && sorted_by_id(can::kMasterRx) && sorted_by_id(can::kPlantRx));

}  // namespace voltlap::codec
