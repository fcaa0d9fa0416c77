// SPDX-License-Identifier: Apache-2.0
// The straights and arcs of a course that its points make most probable: how many there are, which are straight, and
// where each begins.
//
// From arcs about where the points want them (PointPiece), whatever makes a place more probable is done, each change
// judged with the two arcs on both sides of it fitted anew (ArcChain): an arc becomes straight or begins or ends with a
// straight, two to five become one, one goes to its neighbours, a bend comes between two. The points' noise is measured
// in between. Of the rounds the one of the least information is the result.
//
// Exact points of a course of segments give these segments: nothing rings where a corner begins.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "race/track/import/arc_chain_fit.hpp"

namespace voltlap::plant {

struct ArcSearchOptions {
  bool noise_measured = true;               ///< from the points, beginning with the course's
  std::function<void(double)> progress{};  ///< share done, 0 to 1
};

/// `course`: more arcs than there are, about where the points are. Gives the arcs from the same place on.
[[nodiscard]] ArcCourse search_arcs(ArcCourse course, const std::vector<WeightedPoint>& points,
                                    const ArcSearchOptions& options);

/// All arcs fitted at once: what the search begins with.
void fit_course(ArcCourse& course, const std::vector<WeightedPoint>& points);

/// Bayesian information (Schwarz, 1978): of courses that fit alike the one of fewer figures is less.
[[nodiscard]] double information(const ArcCourse& course, std::size_t points);

}  // namespace voltlap::plant
