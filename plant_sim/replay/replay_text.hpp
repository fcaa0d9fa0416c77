// SPDX-License-Identifier: Apache-2.0
// The result of a replay for people, and as files.
#pragma once
#include <string>
#include <vector>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

/// What the terminal shows.
[[nodiscard]] std::string replay_text(const ReplayResult& result);
/// All of it but the rows.
[[nodiscard]] std::string replay_json(const ReplayResult& result, const std::string& version);
/// The rows: ten a second.
[[nodiscard]] std::string replay_csv(const ReplayResult& result);

/// What a second run is drawn by: times, SOC, limits and state of such a file.
[[nodiscard]] std::vector<ReplayRow> rows_of_csv(const std::string& text);

/// "cell 31, cell voltage", "configured maximum": why a limit is what it is.
[[nodiscard]] std::string reason_text(can::LimitReason reason, int cell);

}  // namespace voltlap::plant
