// SPDX-License-Identifier: Apache-2.0
// An explanation as JSON.
#pragma once
#include <string>

#include "discrepancy/explain.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string explanation_json(const Explanation& explanation, std::uint64_t seed,
                                           const std::string& version, const std::string& extended_model);

}  // namespace voltlap::plant
