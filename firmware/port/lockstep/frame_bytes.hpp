// SPDX-License-Identifier: Apache-2.0
// A frame on a stream: identifier (little-endian, bit 31: 29 bits), length, 8 bytes of data, 3 of zero.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap::port {

inline constexpr std::size_t kFrameBytes = 16;

inline void frame_to_bytes(const Frame& frame, std::uint8_t* bytes) {
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(frame.id >> (8 * i));
  bytes[4] = frame.dlc;
  for (std::size_t i = 0; i < Frame::kMaxBytes; ++i) bytes[5 + i] = frame.data[i];
  for (std::size_t i = 5 + Frame::kMaxBytes; i < kFrameBytes; ++i) bytes[i] = 0;
}

/// False for what no frame looks like: the stream is out of step, or another program writes to it.
[[nodiscard]] inline bool frame_from_bytes(const std::uint8_t* bytes, Frame& frame) {
  frame.id = 0;
  for (std::size_t i = 0; i < 4; ++i) frame.id |= std::uint32_t{bytes[i]} << (8 * i);
  frame.dlc = bytes[4];
  for (std::size_t i = 0; i < Frame::kMaxBytes; ++i) frame.data[i] = bytes[5 + i];
  if (frame.dlc > Frame::kMaxBytes) return false;
  for (std::size_t i = 5 + frame.dlc; i < kFrameBytes; ++i) {
    if (bytes[i] != 0) return false;
  }
  return true;
}

}  // namespace voltlap::port
