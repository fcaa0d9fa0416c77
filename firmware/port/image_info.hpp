// SPDX-License-Identifier: Apache-2.0
// What an image says about itself, behind its vector table: which nodes it holds, for how many cells, of which version,
// and whose configuration is in it.
// Made at build time (toolchain/image.cmake); `voltlap flash` and the plant read it.
#pragma once
#include <cstdint>

namespace voltlap::port {

inline constexpr std::uint32_t kImageMark = 0x324C'5456;  ///< "VTL2" in memory

struct ImageInfo {
  std::uint32_t mark = 0;
  std::uint16_t cells_max = 0;       ///< of the BMS, VOLTLAP_CELLS_MAX
  bool has_bms = false;
  bool has_master = false;
  std::uint32_t config_layout = 0;   ///< of bms::Config and master::Config: equal numbers, equal bytes
  std::uint32_t node_sources = 0;    ///< of the nodes and their messages: equal numbers, equal frames
  char name[24] = {};                ///< of the image, ends with a zero
  char version[16] = {};             ///< of the project, ends with a zero
  std::uint32_t bms_number = 0;      ///< of its configuration; 0: it has none, or one that was changed by hand
  std::uint32_t master_number = 0;
  std::uint16_t cells_in_series = 0; ///< of the pack that the configuration is for
  std::uint16_t reserved = 0;
  char car[24] = {};                 ///< whose configuration it is, ends with a zero; empty: it has none
};

extern const ImageInfo kImageInfo;

}  // namespace voltlap::port
