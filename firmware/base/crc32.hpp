// SPDX-License-Identifier: Apache-2.0
// CRC-32 of IEEE 802.3 (reflected, 0xEDB88320, both ends inverted), bit by bit: what is kept is seldom written.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap {

inline constexpr std::uint32_t kCrc32Start = 0xFFFF'FFFFU;

[[nodiscard]] constexpr std::uint32_t crc32_step(std::uint32_t crc, const std::uint8_t* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xEDB8'8320U : crc >> 1;
  }
  return crc;
}
[[nodiscard]] constexpr std::uint32_t crc32_finish(std::uint32_t crc) { return ~crc; }
[[nodiscard]] constexpr std::uint32_t crc32(const std::uint8_t* bytes, std::size_t count) {
  return crc32_finish(crc32_step(kCrc32Start, bytes, count));
}

}  // namespace voltlap
