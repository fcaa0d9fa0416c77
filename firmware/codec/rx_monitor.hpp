// SPDX-License-Identifier: Apache-2.0
// Which received frames may be believed: right length, whole (CRC), new (counter), and which messages are still fresh.
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
  kNotNew = 3,           ///< counter repeated, or moved by more than kCounterStepMax: refreshes nothing
  kResynchronising = 4,  ///< first good frame at boot or after a timeout; the next good one counts
  kAccepted = 5,
};

/// Counter steps that are believed: 1 is the next frame, 2 and 3 mean that one or two frames were lost.
inline constexpr std::uint8_t kCounterStepMax = 3;

/// What is remembered of one message. All-zero memory: never received.
struct RxRow {
  enum class Sync : std::uint8_t { kNever = 0, kFirst = 1, kSynchronised = 2 };
  Instant time{};  ///< of the last frame that was accepted, or that began the synchronisation
  std::uint8_t counter = 0;
  Sync sync = Sync::kNever;
};

/// Judges one frame against its row and moves the row on when the frame is good.
[[nodiscard]] RxVerdict judge(const can::MessageRow& row, RxRow& state, const Frame& frame, Instant now);

/// True until the age of the remembered frame reaches the timeout of its message.
[[nodiscard]] bool in_time(const can::MessageRow& row, const RxRow& state, Instant now);

/// Fresh until the age of the last accepted frame reaches the timeout. A time in the future is not fresh.
[[nodiscard]] bool fresh(const can::MessageRow& row, const RxRow& state, Instant now);

/// The monitor of one node: `kTable` is its generated rx table.
template <const auto& kTable>
class RxMonitor {
 public:
  static constexpr std::size_t kRows = row_count(kTable);

  /// kAccepted: the contents may be used. Anything else: leave everything as it was.
  [[nodiscard]] RxVerdict receive(const Frame& frame, Instant now) {
    const std::size_t row = find_row(kTable, kRows, frame.id);
    return row == kNoRow ? RxVerdict::kUnknownId : judge(kTable[row], rows_[row], frame, now);
  }

  /// Forgets what has timed out. Once a step, so that a silence of weeks cannot look fresh when the time wraps.
  void expire(Instant now) {
    for (std::size_t i = 0; i < kRows; ++i) {
      if (!in_time(kTable[i], rows_[i], now)) rows_[i] = RxRow{};
    }
  }

  [[nodiscard]] bool fresh(std::uint32_t id, Instant now) const {
    const std::size_t row = find_row(kTable, kRows, id);
    return row != kNoRow && codec::fresh(kTable[row], rows_[row], now);
  }

 private:
  RxRow rows_[kRows] = {};
};

}  // namespace voltlap::codec
