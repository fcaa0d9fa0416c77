// SPDX-License-Identifier: Apache-2.0
// Which frames of a recording are played: identifiers, a stretch of time, one of several buses.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

/// Identifiers from one to another, both included; bit 31 set: of 29 bits.
struct IdRange {
  std::uint32_t first = 0, last = 0;
  [[nodiscard]] bool holds(std::uint32_t id) const { return id >= first && id <= last; }
};

/// 6B0, 0x6B0, 6B0-6BF. More than three digits or a value beyond 7FF: 29 bits. False for anything else.
[[nodiscard]] bool parse_id_range(std::string_view text, IdRange& out);
[[nodiscard]] std::string id_range_text(const IdRange& range);

struct FrameChoice {
  double from_s = 0.0, to_s = 1e300;  ///< after the first frame of the recording, both included
  std::string channel{};              ///< empty: the only bus
  std::vector<IdRange> ids{};         ///< empty: every one

  [[nodiscard]] bool has_id(std::uint32_t id) const;
};

}  // namespace voltlap::plant
