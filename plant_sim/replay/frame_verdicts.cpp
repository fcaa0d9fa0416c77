// SPDX-License-Identifier: Apache-2.0
#include "replay/frame_verdicts.hpp"

#include <fmt/format.h>

#include "codec/rx_monitor.hpp"
#include "replay/own_recording.hpp"

namespace voltlap::plant {
namespace {

using codec::RxVerdict;

bool is_corrupt(RxVerdict verdict) { return verdict == RxVerdict::kCorrupt || verdict == RxVerdict::kWrongLength; }

bool is_answer(std::uint32_t id) {
  return codec::find_row(can::kBmsTx, codec::row_count(can::kBmsTx), id) != codec::kNoRow ||
         codec::find_row(can::kMasterTx, codec::row_count(can::kMasterTx), id) != codec::kNoRow;
}

}  // namespace

void add_left_out(const CanSummary& summary, FrameAccount& account, std::vector<LogDefect>& defects) {
  for (const CanDefect& defect : summary.defects) {
    defects.push_back({defect.kind, "", defect.count, defect.first_s,
                       fmt::format("{} x {}{}, first in line {}", defect.count, defect.kind,
                                   defect.used ? " (used)" : ", left out", defect.first_line)});
  }
  account.add_left_out(summary);
}

void judge_frames(const std::vector<OwnFrame>& frames, std::size_t cells, FrameAccount& account) {
  codec::RxMonitor<can::kBmsRx> bms;
  codec::RxMonitor<can::kMasterRx> master;
  for (const OwnFrame& own : frames) {
    if (is_answer(own.frame.id)) {
      ++account.used;
      continue;
    }
    const Instant now = Instant::from_ms(own.tick * can::kTickMs);
    const RxVerdict by_bms = bms.receive(own.frame, now, cells), by_master = master.receive(own.frame, now);
    if (by_bms == RxVerdict::kAccepted || by_master == RxVerdict::kAccepted) {
      ++account.used;
    } else if (is_corrupt(by_bms) || is_corrupt(by_master)) {
      ++account.corrupt;
    } else if (by_bms == RxVerdict::kUnknownId && by_master == RxVerdict::kUnknownId) {
      ++account.ignored;
    } else {
      ++account.stale;
    }
  }
}

}  // namespace voltlap::plant
