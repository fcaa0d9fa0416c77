// SPDX-License-Identifier: Apache-2.0
// The index of a campaign as one JSON object: all that is needed to repeat it, what it was expected to do, what it
// did.
#pragma once
#include <string>
#include <vector>

#include "learn/bench/campaign_files.hpp"

namespace voltlap::plant {

/// JSON text with a final newline. The truth of cells and instruments is in it only `with_truth`.
[[nodiscard]] std::string campaign_index(const Campaign& campaign, const Forecast& forecast,
                                         const std::vector<TestResult>& results,
                                         const std::vector<std::string>& settings, bool with_truth);

}  // namespace voltlap::plant
