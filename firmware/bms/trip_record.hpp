// SPDX-License-Identifier: Apache-2.0
// Latched trips as bytes for a memory that outlives the supply: two slots, written in turns, each with its own CRC and
// the number of its writing. A write that is cut off at any byte damages one slot; the other is what stood before.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::bms {

struct TripRecord {
  std::uint32_t latched = 0;  ///< bits of can::BmsFault
  std::uint16_t writing = 0;  ///< counts up and round
};

inline constexpr std::size_t kTripRecordBytes = 8;
inline constexpr std::size_t kTripSlots = 2;

struct TripSlot {
  std::uint8_t bytes[kTripRecordBytes] = {};
};

[[nodiscard]] TripSlot to_slot(const TripRecord& record);

/// What two slots say together.
struct TripHistory {
  TripRecord newest{};
  std::size_t oldest_slot = 0;  ///< that the next record goes to
  bool damaged = false;         ///< no slot is good, and they are not blank: nobody knows what was latched
};

/// Blank memory, all 0xFF or all zero, is a node that has never tripped.
[[nodiscard]] TripHistory read_slots(const TripSlot (&slots)[kTripSlots]);

}  // namespace voltlap::bms
