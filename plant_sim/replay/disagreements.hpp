// SPDX-License-Identifier: Apache-2.0
// Where firmware and recording do not agree, ranked by what it could have cost: a trip while the car drove on, a cell
// outside of its limits, a current beyond what the firmware allowed, limits and SOC that the car's own unit said.
#pragma once
#include "replay/replay_result.hpp"

namespace voltlap::plant {

[[nodiscard]] std::vector<Disagreement> find_disagreements(const ReplayResult& result);

}  // namespace voltlap::plant
