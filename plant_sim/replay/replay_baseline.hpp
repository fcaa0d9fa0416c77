// SPDX-License-Identifier: Apache-2.0
// What has changed between two replays of one log, for a person to read.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

/// Lines, empty when nothing has changed: a value as `was -> is`; entries of a list that came, went, or are no longer
/// the same, paired by what they are about; of a series how many points differ, and the farthest. Names and paths of
/// log, map, pack and program are not compared. Throws InputError when the file is not what `replay --json` writes.
[[nodiscard]] std::vector<std::string> changes_since(const std::string& baseline_path, const std::string& now_json);

/// The same of two results in memory.
[[nodiscard]] std::vector<std::string> changes_between(const std::string& was_json, const std::string& is_json);

}  // namespace voltlap::plant
