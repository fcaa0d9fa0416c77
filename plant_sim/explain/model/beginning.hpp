// SPDX-License-Identifier: Apache-2.0
// How a log begins: with branches that are at rest, or that a drive before it has charged. Nobody recorded that; the
// first minutes tell.
#pragma once
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// Share of the squares that a level, a drift, and errors of resistance leave of the main voltage in the first minutes,
/// which is left when branches may be charged besides; 1: nothing is there to be taken.
[[nodiscard]] double left_beside_charge(const Observed& log);

/// How full the cells are after each gap, as was counted or else from the voltage of the minutes that follow: near
/// enough for what is left to be a straight line.
void settle_gaps(const plant::World& model, plant::Comparison& comparison);

}  // namespace voltlap::explain
