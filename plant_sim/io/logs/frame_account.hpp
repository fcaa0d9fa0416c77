// SPDX-License-Identifier: Apache-2.0
// What became of every frame of a recording; nothing goes uncounted.
#pragma once
#include <cstddef>

namespace voltlap::plant {

struct CanSummary;

/// used + ignored + corrupt + stale = in_file. Of a table the samples of its roles are counted.
struct FrameAccount {
  std::size_t in_file = 0;
  std::size_t used = 0;     ///< some value of it was taken
  std::size_t ignored = 0;  ///< whole, and nobody reads it
  std::size_t corrupt = 0;  ///< unreadable, against its checksum, or without any value that may be believed
  std::size_t stale = 0;    ///< its time is wrong, or it is a copy

  [[nodiscard]] std::size_t accounted() const { return used + ignored + corrupt + stale; }
  /// Those that the reader of the recording has left out.
  void add_left_out(const CanSummary& summary);
};

}  // namespace voltlap::plant
