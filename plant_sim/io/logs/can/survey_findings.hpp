// SPDX-License-Identifier: Apache-2.0
// What is wrong with a recording, in words, each kind with its size and place; and how its frames add up.
#pragma once
#include <string>
#include <vector>

#include "io/logs/can/frame_survey.hpp"

namespace voltlap::plant {

struct Finding {
  std::string kind;   ///< such as "gap", the same words in every recording
  std::string where;  ///< a frame, a signal; empty: the recording
  std::size_t count = 0;
  std::string text;   ///< a sentence without a full stop
};

/// Defects of the frames and of the clock, gaps, and what the DBC files contradict: frames that are too short, values
/// out of range, frames that a file has and that cannot be used. In the order: recording, frames, signals.
[[nodiscard]] std::vector<Finding> findings(const RecordingSurvey& survey, const DbcSet& dbc);

/// Frames used and frames left out by kind, which are together the frames in the file.
[[nodiscard]] std::string account_text(const CanSummary& summary);

/// What is wrong with the DBC files themselves, whether or not the recording has the frames; empty: nothing.
[[nodiscard]] std::string dbc_faults_text(const DbcSet& dbc);

/// The rules by which last bytes check the others, a line a frame; empty: no frame has one.
[[nodiscard]] std::string checksum_text(const RecordingSurvey& survey);

/// Frames, rates, loads, signals with their ranges, for people. `bit_rate`: of every bus [bit/s].
[[nodiscard]] std::string survey_text(const std::string& path, const RecordingSurvey& survey, double bit_rate);

/// All of it for programs: frames, signals, findings.
[[nodiscard]] std::string survey_json(const std::string& path, const RecordingSurvey& survey, const DbcSet& dbc,
                                      double bit_rate);

}  // namespace voltlap::plant
