// SPDX-License-Identifier: Apache-2.0
// How long a classic CAN data frame is on the wire, bit by bit (ISO 11898-1, 10.4 and 10.5).
//   11-bit identifier  SOF, identifier 11, RTR, IDE, r0, DLC 4                        = 19 bits before the data
//   29-bit identifier  SOF, base 11, SRR, IDE, extension 18, RTR, r1, r0, DLC 4       = 39 bits before the data
//   then 8 n bits of data and the CRC of 15 bits; after five equal bits of all these a stuff bit of the other value is
//   sent, which counts as the first of the next run. CRC delimiter, ACK slot and delimiter, 7 bits of end of frame and
//   3 bits between frames are never stuffed: 13 bits.
// Counting goes by whole bytes through tables: a run of millions of frames is counted in a fraction of a second.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap::plant {

inline constexpr std::uint32_t kCrcBits = 15;
inline constexpr std::uint32_t kUnstuffedBits = 13;

/// What all frames with one identifier and one length have in common: everything before the data.
struct FrameHead {
  std::uint32_t bits = 0;        ///< without stuff bits
  std::uint32_t stuff_bits = 0;  ///< among them
  std::uint8_t state = 0;        ///< of the stuffing, after them
  std::uint16_t crc = 0;         ///< their share of the checksum, which is linear in the bits
};
[[nodiscard]] FrameHead frame_head(std::uint32_t id, std::uint8_t dlc);

/// CRC-15 of a frame, polynomial 0x4599, over the bits from SOF to the end of the data.
[[nodiscard]] std::uint16_t frame_crc(const FrameHead& head, const Frame& frame);

/// Bits of a frame from SOF to the end of the pause after it, with the stuff bits that it really has.
[[nodiscard]] std::uint32_t frame_bits(const FrameHead& head, const Frame& frame);
[[nodiscard]] inline std::uint32_t frame_bits(const Frame& frame) {
  return frame_bits(frame_head(frame.id, frame.dlc), frame);
}

/// The most that stuffing can make of it: g + 8 n + 13 + floor((g + 8 n - 1) / 4), g = 34 or 54 (Davis et al. 2007,
/// Eq. 1).
[[nodiscard]] constexpr std::uint32_t frame_bits_worst(std::uint8_t dlc, bool extended) {
  const std::uint32_t stuffed = (extended ? 54U : 34U) + 8U * dlc;
  return stuffed + kUnstuffedBits + (stuffed - 1U) / 4U;
}

}  // namespace voltlap::plant
