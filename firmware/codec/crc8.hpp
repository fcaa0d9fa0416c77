// SPDX-License-Identifier: Apache-2.0
// CRC-8 SAE J1850: polynomial 0x1D, start 0xFF, final xor 0xFF, not reflected. CRC of "123456789" is 0x4B.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::codec {

struct Crc8Table {
  std::uint8_t of[256] = {};
};

[[nodiscard]] constexpr Crc8Table make_crc8_table() {
  constexpr std::uint32_t kPolynomial = 0x1D;
  Crc8Table table;
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80U) != 0 ? (crc << 1) ^ kPolynomial : crc << 1;
    table.of[byte] = static_cast<std::uint8_t>(crc & 0xFFU);
  }
  return table;
}

inline constexpr Crc8Table kCrc8Table = make_crc8_table();
inline constexpr std::uint8_t kCrc8Start = 0xFF;

/// One byte further, without the final xor.
[[nodiscard]] constexpr std::uint8_t crc8_step(std::uint8_t crc, std::uint8_t byte) {
  return kCrc8Table.of[crc ^ byte];
}

[[nodiscard]] constexpr std::uint8_t crc8_finish(std::uint8_t crc) { return static_cast<std::uint8_t>(crc ^ 0xFFU); }

}  // namespace voltlap::codec
