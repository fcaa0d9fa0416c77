// SPDX-License-Identifier: Apache-2.0
// How image and plant meet on a stream, before the first frame:
//
//   image   Greeting          who it is, and whether it waits for a configuration or whose it has
//   plant   Configuration     head, bms::Config, master::Config, only if it does; the head says which of its nodes run
//   image   READY of its nodes, then frames: see lockstep_port.hpp
//
// The configurations go as they lie in memory, so both sides must lay them out alike: sizes and the number
// `config_layout`, made from the text of their headers, say so.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port {

inline constexpr std::uint32_t kGreetingMark = 0x3348'4C56;       ///< "VLH3"
inline constexpr std::uint32_t kConfigurationMark = 0x3246'4C56;  ///< "VLF2"

struct Greeting {
  std::uint32_t mark = kGreetingMark;
  std::uint32_t config_layout = 0, node_sources = 0;            ///< port/source_numbers.hpp
  std::uint32_t bms_config_bytes = 0, master_config_bytes = 0;  ///< 0: the image has its own
  std::uint16_t cells_max = 0, temperatures_max = 0;
  std::uint8_t has_bms = 0, has_master = 0;
  std::uint16_t cells_in_series = 0;                            ///< of its own configuration, as image_info.hpp
  std::uint32_t bms_number = 0, master_number = 0;
  char car[24] = {};
};
static_assert(sizeof(Greeting) == 60, "no padding: it goes onto the stream as it lies in memory");

struct ConfigurationHead {
  std::uint32_t mark = kConfigurationMark;
  std::uint32_t config_layout = 0;
  std::uint32_t bms_config_bytes = 0, master_config_bytes = 0;
  std::uint8_t runs_bms = 1, runs_master = 1;  ///< of the nodes of the image; one of them at least
  std::uint8_t reserved[2] = {};
};
static_assert(sizeof(ConfigurationHead) == 20, "no padding");

}  // namespace voltlap::port
