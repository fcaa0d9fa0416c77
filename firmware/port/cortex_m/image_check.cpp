// SPDX-License-Identifier: Apache-2.0
#include "port/image_check.hpp"

#include "base/crc32_table.hpp"

extern "C" {
extern const std::uint32_t __image_begin, __image_end;  // sections.ld
}

namespace voltlap::port {

// BMS-091
std::uint32_t image_residue() {
  std::uint32_t crc = kCrc32Start;
  for (const std::uint32_t* word = &__image_begin; word < &__image_end; ++word) crc = crc32_word(crc, *word);
  return crc32_finish(crc);
}

}  // namespace voltlap::port
