// SPDX-License-Identifier: Apache-2.0
#include "io/logs/frame_checksum.hpp"

#include <numeric>

#include "codec/crc8.hpp"

namespace voltlap::plant {
namespace {

std::uint8_t crc_of(std::uint32_t id, const std::uint8_t* first, const std::uint8_t* end) {
  std::uint8_t crc = codec::crc8_step(codec::kCrc8Start, static_cast<std::uint8_t>(id >> 8));
  crc = codec::crc8_step(crc, static_cast<std::uint8_t>(id));
  return codec::crc8_finish(std::accumulate(first, end, crc, codec::crc8_step));
}

}  // namespace

bool checksum_holds(FrameChecksum rule, const RecordedFrame& frame) {
  constexpr std::size_t kLast = Frame::kMaxBytes - 1;
  if (rule == FrameChecksum::kNone) return true;
  if (frame.length != Frame::kMaxBytes) return false;
  const std::uint32_t id = frame.id & ~RecordedFrame::kExtendedFlag;
  const std::uint8_t* end = frame.data + kLast;
  if (rule == FrameChecksum::kCrc8) return crc_of(id, frame.data, end) == *end;
  const unsigned begin = rule == FrameChecksum::kOrion ? id + frame.length : 0U;
  return (std::accumulate(frame.data, end, begin) & 0xFFU) == *end;
}

}  // namespace voltlap::plant
