// SPDX-License-Identifier: Apache-2.0
// What a reader of a result would not guess: a setting that leaves something as it was, a table that was left.
#pragma once
#include <string>
#include <vector>

#include "race/report/run_result.hpp"

namespace voltlap::plant {

/// A sentence each; none for most runs.
[[nodiscard]] std::vector<std::string> run_notes(const RunDescription& run, const VehicleParameters& car,
                                                 const EnduranceResult& result);

}  // namespace voltlap::plant
