// SPDX-License-Identifier: Apache-2.0
// The packet error code of the LTC6811 (datasheet, "PEC calculation"): a CRC of 15 bits by 0x4599 from 0x0010, shifted
// up by one.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port::afe {

[[nodiscard]] constexpr std::uint16_t pec15(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t pec = 0x0010;
  for (std::size_t i = 0; i < count; ++i) {
    pec ^= std::uint32_t{bytes[i]} << 7;
    for (int bit = 0; bit < 8; ++bit) pec = (pec & 0x4000U) != 0 ? (pec << 1 ^ 0x4599U) & 0x7FFFU : pec << 1 & 0x7FFFU;
  }
  return static_cast<std::uint16_t>(pec << 1);
}

}  // namespace voltlap::port::afe
