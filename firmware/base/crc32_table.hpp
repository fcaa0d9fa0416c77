// SPDX-License-Identifier: Apache-2.0
// The CRC-32 of base/crc32.hpp over whole words by a table of 256: for much at once, as an image in flash.
#pragma once
#include "base/crc32.hpp"

namespace voltlap {

struct Crc32Table {
  std::uint32_t of[256] = {};
};
[[nodiscard]] constexpr Crc32Table crc32_table() {
  Crc32Table table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    const std::uint8_t byte = static_cast<std::uint8_t>(i);
    table.of[i] = crc32_step(0, &byte, 1);
  }
  return table;
}
inline constexpr Crc32Table kCrc32Table = crc32_table();

/// The four bytes of a word, the lowest first.
[[nodiscard]] constexpr std::uint32_t crc32_word(std::uint32_t crc, std::uint32_t word) {
  crc ^= word;
  for (int byte = 0; byte < 4; ++byte) crc = kCrc32Table.of[crc & 0xFFU] ^ crc >> 8;
  return crc;
}

}  // namespace voltlap
