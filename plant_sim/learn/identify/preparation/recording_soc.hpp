// SPDX-License-Identifier: Apache-2.0
// The SOC of recordings of one cell, together: between tests a cell ages, testers count differently, and what one calls
// full another does not.
//
//   SOC_k(t) = s_k + o_k - q(t) (1 + c_k) / C        o_k, c_k: found with the tables, normal around 0
//
// Only differences between recordings are told by them: a capacity that is common to all bends no voltage.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// The middle capacity: the cell's. Whether a recording was moved.
struct SettledSoc {
  double capacity_ah = 0.0;
  bool moved = false;
};

/// Moves the anchors and capacities of two recordings or more to where one table follows all of them best, if that is
/// better than where they stood; `notes` says which have a capacity of their own. All are anchored. The fullest stands
/// at SOC 1 and, where the capacity is what was drawn, the emptiest at 0.
[[nodiscard]] SettledSoc settle_soc(std::vector<PreparedLog>& prepared, FitPriors priors, bool capacity_told,
                                    std::vector<std::string>& notes);

}  // namespace voltlap::plant
