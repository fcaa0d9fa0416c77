// SPDX-License-Identifier: Apache-2.0
// For a board that measures its cells itself: the frames that a cell monitor on the bus would send, sealed, at the
// times of the DBC. They reach the BMS with those off the bus, so that everything it holds against frames holds for
// them, too.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"
#include "codec/seal.hpp"

namespace voltlap::app {

class CellMonitor {
 public:
  /// The most frames that one tick brings: every group of a pack, where cells are many and all are due.
  static constexpr std::size_t kFramesMax = can::CellVoltages::kGroups + can::Temperatures::kGroups;

  explicit CellMonitor(std::size_t cells, std::size_t sensors) : cells_(cells), sensors_(sensors) {}

  /// `board` is a port::Cells. Frames of what is due now and has been measured; of a group that the board has nothing
  /// new of none is sent, and its samples grow old. Returns how many; `frames` has room for kFramesMax.
  template <class Board>
  std::size_t frames(Instant now, Board& board, Frame* frames) {
    std::size_t count = 0;
    add<can::CellVoltages>(now, board, cells_, can::cell_cycle_ms(cells_), frames, count);
    add<can::Temperatures>(now, board, sensors_, can::Temperatures::kCycleMs, frames, count);
    return count;
  }

 private:
  template <class Message, class Board>
  void add(Instant now, Board& board, std::size_t values, std::int32_t cycle_ms, Frame* frames, std::size_t& count) {
    for (std::size_t group = 0; group < Message::kGroups && group * Message::kPerFrame < values; ++group) {
      if (!can::due(now.ms(), cycle_ms, static_cast<std::int32_t>(can::kTickMs * group))) continue;
      Message message;
      message.group = static_cast<std::uint8_t>(group);
      if (!board.take(message)) continue;
      can::encode(message, frames[count]);
      sealer_.seal(frames[count]);
      ++count;
    }
  }

  std::size_t cells_;
  std::size_t sensors_;
  codec::Sealer sealer_{};
};

}  // namespace voltlap::app
