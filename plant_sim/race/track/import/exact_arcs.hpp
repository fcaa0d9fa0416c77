// SPDX-License-Identifier: Apache-2.0
// Straights and arcs through points without noise, about a line that follows them: the points are cut into pieces that
// lie on one straight or circle (PointPiece); where two of these touch, one arc ends and the next begins; then the
// points decide which arcs stay (ArcSearch).
#pragma once
#include "race/track/import/arc_search.hpp"
#include "race/track/import/node_chain.hpp"

namespace voltlap::plant {

/// `line`: linearised, with `noise_m` of the points about it.
[[nodiscard]] ArcCourse find_exact_arcs(const NodeChain& line, double noise_m, const ArcSearchOptions& options);

}  // namespace voltlap::plant
