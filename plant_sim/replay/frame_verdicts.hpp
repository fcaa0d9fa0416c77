// SPDX-License-Identifier: Apache-2.0
// What became of the frames of a recording. Used, ignored, corrupt and stale are together the frames of the file.
#pragma once
#include <vector>

#include "io/logs/can/can_recording.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct OwnFrame;

/// Frames that the reader has left out: corrupt, or stale where only their time is wrong; and every defect in words.
void add_left_out(const CanSummary& summary, FrameAccount& account, std::vector<LogDefect>& defects);

/// Frames of our own bus, by the monitors that the nodes judge them with: what either of them believes is used; a
/// copy, a foreign count, a count that is not known yet is stale. What the nodes sent then is used: it is compared.
void judge_frames(const std::vector<OwnFrame>& frames, std::size_t cells, FrameAccount& account);

}  // namespace voltlap::plant
