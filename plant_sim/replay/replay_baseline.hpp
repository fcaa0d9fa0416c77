// SPDX-License-Identifier: Apache-2.0
// The result of a replay beside that of an earlier one of the same log: what a change of the firmware has changed.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

/// A line for each value that differs, "faults/0/time_s: 43.8 -> 43.7", in the order of the newer one. Version and path
/// of the log do not count. Throws InputError for a baseline that is no JSON of a replay.
[[nodiscard]] std::vector<std::string> changes_since(const std::string& baseline_path, const std::string& now_json);

}  // namespace voltlap::plant
