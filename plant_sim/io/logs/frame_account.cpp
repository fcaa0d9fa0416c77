// SPDX-License-Identifier: Apache-2.0
#include "io/logs/frame_account.hpp"

#include <string_view>

#include "io/logs/can/can_recording.hpp"

namespace voltlap::plant {
namespace {

bool says(std::string_view kind, std::string_view word) { return kind.find(word) != std::string_view::npos; }

}  // namespace

void FrameAccount::add_left_out(const CanSummary& summary) {
  for (const CanDefect& defect : summary.defects) {
    if (defect.used) continue;
    const bool by_time = says(defect.kind, "time") || says(defect.kind, "stamp");
    const bool empty = says(defect.kind, "remote") || says(defect.kind, "empty");
    (by_time ? stale : empty ? ignored : corrupt) += defect.count;
  }
}

}  // namespace voltlap::plant
