// SPDX-License-Identifier: Apache-2.0
// What a chain of monitor chips hangs on: SPI (mode 3, at most 1 MHz) or the same behind an isoSPI transceiver.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port::afe {

class Spi {
 public:
  /// Chip select low, `out` sent, `in_count` bytes read, chip select high. Bounded by the number of bytes.
  virtual void exchange(const std::uint8_t* out, std::size_t out_count, std::uint8_t* in, std::size_t in_count) = 0;
  /// Chip select low and high once, and then at least `us` of silence: what wakes a chip, or the link to it.
  virtual void wake(std::uint32_t us) = 0;

 protected:
  ~Spi() = default;
};

}  // namespace voltlap::port::afe
