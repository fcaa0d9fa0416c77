// SPDX-License-Identifier: Apache-2.0
// An explanation as JSON.
#pragma once
#include <string>

#include "explain/explanation.hpp"
#include "explain/extend/race_change.hpp"

namespace voltlap::plant {

/// `race`: none when no race was driven.
[[nodiscard]] std::string explanation_json(const Explanation& explanation, const RaceChange* race,
                                           std::uint64_t seed, const std::string& version,
                                           const std::string& extended_model);

}  // namespace voltlap::plant
