// SPDX-License-Identifier: Apache-2.0
// Where the bits of a signal stand in a frame, worked out once: one load of 64 bits, a byte swap for Motorola order, a
// shift and a mask give its raw value. Only a signal that begins within a byte and spans nine takes a second load.
// Start bit: of an Intel signal its lowest bit, of a Motorola signal its highest; bit 8 b + k is bit k of byte b.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

static_assert(std::endian::native == std::endian::little, "a frame's bytes are loaded as an Intel number");

class BitField {
 public:
  BitField() = default;
  BitField(unsigned start, unsigned length, bool big_endian) : big_endian_(big_endian) {
    constexpr unsigned kLastWord = RecordedFrame::kMostBytes - sizeof(std::uint64_t);
    const unsigned begin = big_endian ? 8 * (start / 8) + 7 - start % 8 : start;  // in the order of the bytes
    bytes_ = static_cast<std::uint8_t>((begin + length - 1) / 8 + 1);
    first_ = static_cast<std::uint8_t>(std::min(begin / 8, kLastWord));
    const unsigned end = begin - 8U * first_ + length;
    mask_ = length >= kWord ? ~std::uint64_t{0} : (std::uint64_t{1} << length) - 1;
    spill_ = static_cast<std::uint8_t>(end > kWord ? end - kWord : 0);
    shift_ = static_cast<std::uint8_t>(big_endian ? (end > kWord ? 0 : kWord - end) : begin - 8U * first_);
  }

  [[nodiscard]] bool operator==(const BitField&) const = default;

  /// Bytes that a frame must have for it.
  [[nodiscard]] unsigned bytes() const { return bytes_; }
  [[nodiscard]] std::uint64_t mask() const { return mask_; }

  /// `data`: all 64 bytes of a RecordedFrame, whatever its length.
  [[nodiscard]] std::uint64_t raw(const std::uint8_t* data) const {
    std::uint64_t word;
    std::memcpy(&word, data + first_, sizeof word);
    if (big_endian_) word = __builtin_bswap64(word);
    if (spill_ != 0) [[unlikely]] {
      const std::uint64_t ninth = data[first_ + sizeof word];
      const std::uint64_t nine = big_endian_ ? word << spill_ | ninth >> (8 - spill_)
                                             : word >> shift_ | ninth << (kWord - shift_);
      return nine & mask_;
    }
    return word >> shift_ & mask_;
  }

 private:
  static constexpr unsigned kWord = 64;
  std::uint64_t mask_ = 1;
  std::uint8_t first_ = 0, shift_ = 0, spill_ = 0, bytes_ = 1;
  bool big_endian_ = false;
};

}  // namespace voltlap::plant
