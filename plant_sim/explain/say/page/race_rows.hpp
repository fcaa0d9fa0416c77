// SPDX-License-Identifier: Apache-2.0
// The race before and after an explanation, for the report and for --json.
#pragma once
#include <string>

#include "explain/extend/race_change.hpp"

namespace voltlap::plant {

/// End SOC and hottest cell as key numbers; empty without a race.
[[nodiscard]] std::string race_tiles(const RaceChange* race);

/// The section of the report; empty without a race.
[[nodiscard]] std::string race_section(const RaceChange* race);

/// As JSON text, SI, shares 0..1; `null` without a race.
[[nodiscard]] std::string race_json(const RaceChange* race);

}  // namespace voltlap::plant
