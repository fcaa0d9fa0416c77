// SPDX-License-Identifier: Apache-2.0
// Which received frames may be believed: right length, whole (CRC), next in the count of one sender; and which messages
// are still fresh.
//
// One sender counts its frames 0 to 255 and round again, one a cycle. So a frame that is C counts after the last one
// may not come before C cycles have passed since then:
//   C cycle <= gap + lateness + cycle / 2     or C = 1: the next frame is believed whenever it comes
// with the lateness of the last frame against the earliest ones. It may come later, but not when another frame has just
// claimed its count. Frames that were lost leave a gap in the count and as
// long a gap in time: the first one behind it is believed. What breaks the rule has another sender, or is a replay.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/tables.hpp"
#include "codec/message_table.hpp"

namespace voltlap::codec {

enum class RxVerdict : std::uint8_t {
  kUnknownId = 0,        ///< not in this node's table
  kWrongLength = 1,
  kCorrupt = 2,          ///< CRC or checksum does not match
  kCopy = 3,             ///< byte for byte the frame before it: refreshes nothing
  kForeign = 4,          ///< a counter that jumps without a gap in time, or other contents under a counter in use
  kResynchronising = 5,  ///< whole, but its count is not known yet or not trusted again; refreshes nothing
  kAccepted = 6,
};

/// Frames of one message that refreshed nothing. They count to 65535 and stay there.
struct RxCounts {
  std::uint16_t wrong_length = 0;
  std::uint16_t corrupt = 0;
  std::uint16_t copies = 0;
  std::uint16_t foreign = 0;
};

/// A gap from here on says nothing about the count, which has come half round: two successive frames are needed.
inline constexpr std::int32_t kGapMaxCycles = 128;
/// Foreign frames in so many of the last eight cycles: the message is contested. Of one that is slower than a tick two
/// are enough, so that the torque is gone in time.
[[nodiscard]] constexpr int foreign_cycles_max(std::int32_t cycle_ms) {
  return cycle_ms > static_cast<std::int32_t>(can::kTickMs) ? 2 : 3;
}
/// A contested message is believed again after a whole round of the counter without a jump: no replay of a shorter
/// period gets there.
inline constexpr std::uint16_t kCleanSteps = 256;

/// What is remembered of one message. All-zero memory: never received.
struct RxRow {
  enum class Sync : std::uint8_t { kNever = 0, kFirst = 1, kSynchronised = 2 };
  Instant time{};             ///< of the frame that the next one is judged by
  Instant heard{};            ///< of the last whole frame that was no copy
  Instant foreign_cycle{};    ///< begin of the cycle of bit 0 of `foreign_cycles`
  std::int32_t late_us = 0;   ///< how late that frame was against the earliest ones
  std::uint16_t clean = 0;    ///< counter steps without a jump since it is contested
  std::uint8_t foreign_cycles = 0;  ///< one bit a cycle, the newest lowest: there was a foreign frame
  std::uint8_t settling = 0;  ///< frames for which the lateness is not known well
  std::uint8_t counter = 0;
  std::uint8_t payload[Frame::kMaxBytes] = {};
  Sync sync = Sync::kNever;
  bool contradicted = false;  ///< within those eight cycles: one counter, two contents
  bool contested = false;     ///< a second sender or a replay: nothing of this message is believed
  RxCounts counts{};
};

/// Judges one frame against its row and moves the row on when the frame is good. `cycle_ms`: of the message in a car.
[[nodiscard]] RxVerdict judge(const can::MessageRow& row, std::int32_t cycle_ms, RxRow& state, const Frame& frame,
                              Instant now);

/// Forgets a count that has come half round, and foreign frames of long ago.
void forget_old(std::int32_t cycle_ms, RxRow& state, Instant now);

/// A small pack's table has rows of cells that it does not have. What is contradicted is among the foreign cycles.
[[nodiscard]] inline bool has_something_to_forget(const RxRow& state) {
  return state.sync != RxRow::Sync::kNever || state.foreign_cycles != 0;
}

/// Fresh until the age of the last accepted frame reaches the timeout. A time in the future is not fresh.
[[nodiscard]] bool fresh(const can::MessageRow& row, const RxRow& state, Instant now);

/// The monitor of one node: `kTable` is its generated rx table.
template <const auto& kTable>
class RxMonitor {
 public:
  static constexpr std::size_t kRows = row_count(kTable);

  /// kAccepted: the contents may be used. Anything else: leave everything as it was. `cells`: of the pack, on which the
  /// cycle of the cell voltages depends.
  [[nodiscard]] RxVerdict receive(const Frame& frame, Instant now, std::size_t cells = 0) {
    const std::size_t row = find_row(kTable, kRows, frame.id);
    if (row == kNoRow) return RxVerdict::kUnknownId;
    return judge(kTable[row], cycle_ms(row, cells), rows_[row], frame, now);
  }

  /// Once a step, so that a silence of weeks cannot look fresh when the time wraps.
  void expire(Instant now, std::size_t cells = 0) {
    for (std::size_t i = 0; i < kRows; ++i) {
      if (has_something_to_forget(rows_[i])) forget_old(cycle_ms(i, cells), rows_[i], now);
    }
  }

  [[nodiscard]] bool fresh(std::uint32_t id, Instant now) const {
    const std::size_t row = find_row(kTable, kRows, id);
    return row != kNoRow && codec::fresh(kTable[row], rows_[row], now);
  }

  /// Some message has a second sender or is replayed.
  [[nodiscard]] bool contested() const {
    for (const RxRow& row : rows_) {
      if (row.contested) return true;
    }
    return false;
  }

  [[nodiscard]] RxCounts counts(std::uint32_t id) const {
    const std::size_t row = find_row(kTable, kRows, id);
    return row == kNoRow ? RxCounts{} : rows_[row].counts;
  }

 private:
  static std::int32_t cycle_ms(std::size_t row, std::size_t cells) {
    return cells > can::kFastCells ? kTable[row].cycle_many_cells_ms : kTable[row].cycle_ms;
  }

  RxRow rows_[kRows] = {};
};

}  // namespace voltlap::codec
