// SPDX-License-Identifier: Apache-2.0
// A tester's end of ISO 15765-2: messages as the frames that it sends.
#pragma once
#include <cstdint>
#include <vector>

#include "base/can_frame.hpp"

namespace voltlap::app::test {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::uint32_t kToNode = 0x18DAB0F1U, kFromNode = 0x18DAF1B0U;

inline Frame frame_of(const Bytes& bytes, std::uint32_t id = kToNode) {
  Frame f;
  f.id = id;
  f.dlc = static_cast<std::uint8_t>(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) f.data[i] = bytes[i];
  return f;
}

/// 1, 2, 3 ...
inline Bytes counted(std::size_t count) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::uint8_t>(i + 1);
  return bytes;
}

/// What a sender of 9.6 makes of a message of more than 7 bytes.
inline std::vector<Frame> segmented(const Bytes& message) {
  Bytes first = {static_cast<std::uint8_t>(0x10 | message.size() >> 8), static_cast<std::uint8_t>(message.size())};
  first.insert(first.end(), message.begin(), message.begin() + 6);
  std::vector<Frame> frames = {frame_of(first)};
  for (std::size_t at = 6; at < message.size(); at += 7) {
    Bytes next = {static_cast<std::uint8_t>(0x20 | (frames.size() & 0xF))};
    for (std::size_t i = at; i < message.size() && i < at + 7; ++i) next.push_back(message[i]);
    frames.push_back(frame_of(next));
  }
  return frames;
}

}  // namespace voltlap::app::test
