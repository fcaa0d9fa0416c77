// SPDX-License-Identifier: Apache-2.0
// The capacity at which each recording agrees with the others: between tests a cell ages, and testers count
// differently.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// Each recording that spans half of the SOC is predicted by a quick fit of the others. Where another capacity, within
/// 15 %, lowers its error by two fifths or more, that capacity counts its SOC; `notes` says so. All recordings are
/// anchored. The one that spans most keeps the capacity that all had; those that do not tell get the middle one of
/// those that do. Returns that middle one [Ah]: the cell's.
double settle_capacities(std::vector<PreparedLog>& prepared, const FitPriors& priors, std::vector<std::string>& notes);

}  // namespace voltlap::plant
