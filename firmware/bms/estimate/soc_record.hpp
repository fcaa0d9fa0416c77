// SPDX-License-Identifier: Apache-2.0
// What soc_ekf knows, as bytes for a memory that outlives the supply: two slots, written in turns, each with its own
// CRC-32 and the number of its writing, as trip_record.hpp. A write that is cut off at any byte damages one slot; the
// other is what stood before.
#pragma once
#include <cstddef>
#include <cstdint>

#include "bms/estimate/soc_estimator.hpp"

namespace voltlap::bms {

/// Of one cell, all that is slower than a restart.
struct CellRecord {
  std::int16_t soc = 0;              ///< [2^-14] beyond both ends too
  std::int16_t v1 = 0, v2 = 0;       ///< [2^-12 of 0.25 V]
  std::uint16_t scale = 1U << 13;    ///< of the resistances [2^-13]
  std::int16_t fade = 0;             ///< how much sooner it is empty [2^-14]
};

struct SocRecord {
  CellRecord cell[kMaxCells] = {};
  std::uint16_t cells = 0;    ///< 0: nothing is known
  std::uint16_t writing = 0;  ///< counts up and round
  std::uint16_t pieces = 0;   ///< of the way, driven since the pack was charged
};

inline constexpr std::size_t kCellRecordBytes = 10;
inline constexpr std::size_t kSocHeadBytes = 8;
inline constexpr std::size_t kSocRecordBytes = kSocHeadBytes + kMaxCells * kCellRecordBytes + 4;
inline constexpr std::size_t kSocSlots = 2;

struct SocSlot {
  std::uint8_t bytes[kSocRecordBytes] = {};
};

/// What the estimate knows now; nothing unless it is valid.
void keep(const Config& config, const SocEstimate& state, SocRecord& record);

/// Before the first step: the record is where the estimate starts, unless the cells' voltages contradict it. One of
/// another number of cells is none.
void restore(const Config& config, const SocRecord& record, SocEstimate& state);

/// Mean of its cells; 0 when nothing is known.
[[nodiscard]] Soc recorded_soc(const SocRecord& record);

void to_slot(const SocRecord& record, SocSlot& slot);

/// The newest good record of the two, none when there is none; `oldest_slot`: that the next one goes to.
void read_slots(const SocSlot (&slots)[kSocSlots], SocRecord& newest, std::size_t& oldest_slot);

}  // namespace voltlap::bms
