// SPDX-License-Identifier: Apache-2.0
// Payload bytes <-> one 64-bit word, and physical integer <-> raw code: what every generated codec is made of.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::payload {

/// Intel order: bit k of the payload (byte k/8, bit k%8) is bit k of the word.
[[nodiscard]] constexpr std::uint64_t load_le(const std::uint8_t* data) {
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < 8; ++i) word |= std::uint64_t{data[i]} << (8 * i);
  return word;
}
constexpr void store_le(std::uint64_t word, std::uint8_t* data) {
  for (std::size_t i = 0; i < 8; ++i) data[i] = static_cast<std::uint8_t>(word >> (8 * i));
}

/// Motorola order: the first bit sent is the highest bit of the word.
[[nodiscard]] constexpr std::uint64_t load_be(const std::uint8_t* data) {
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < 8; ++i) word = (word << 8) | data[i];
  return word;
}
constexpr void store_be(std::uint64_t word, std::uint8_t* data) {
  for (std::size_t i = 0; i < 8; ++i) data[i] = static_cast<std::uint8_t>(word >> (56 - 8 * i));
}

constexpr void copy(const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = from[i];
}

/// The `length` bits of `word` from bit `shift` upward; length 1 to 32.
[[nodiscard]] constexpr std::uint32_t take(std::uint64_t word, unsigned shift, unsigned length) {
  return static_cast<std::uint32_t>((word >> shift) & ((std::uint64_t{1} << length) - 1));
}
[[nodiscard]] constexpr std::uint64_t place(std::uint32_t code, unsigned shift, unsigned length) {
  return (std::uint64_t{code} & ((std::uint64_t{1} << length) - 1)) << shift;
}

/// Two's complement of `length` bits to a signed number.
[[nodiscard]] constexpr std::int32_t sign_extend(std::uint32_t code, unsigned length) {
  const std::uint32_t sign = std::uint32_t{1} << (length - 1);
  return static_cast<std::int32_t>((code ^ sign) - sign);
}

/// value / factor to the nearest raw code, halves away from zero, saturated to [low, high]; factor > 0.
[[nodiscard]] constexpr std::int32_t to_raw(std::int32_t value, std::int32_t factor, std::int32_t low,
                                            std::int32_t high) {
  const std::int64_t wide = value;
  const std::int64_t half = factor / 2;
  const std::int64_t raw = (wide >= 0 ? wide + half : wide - half) / factor;
  return raw < low ? low : (raw > high ? high : static_cast<std::int32_t>(raw));
}

}  // namespace voltlap::payload
