// SPDX-License-Identifier: Apache-2.0
// The report of a replay as one HTML file: what matters most first, then the table of disagreements, whose rows show
// their stretch in the charts of firmware and log. html/replay.js draws.
#pragma once
#include <string>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string replay_report(const ReplayResult& result, const std::string& version);

}  // namespace voltlap::plant
