// SPDX-License-Identifier: Apache-2.0
// The shape of a course as its segments give it, for drawing, and whether it closes.
//
//   x' = cos(psi), y' = sin(psi), psi' = -kappa     (x to the right, y up; kappa > 0 turns right)
//
// A course begins at the origin, along x. Nothing is adjusted: a list of measured corners need not close.
#pragma once
#include <string>
#include <vector>

#include "race/track/track.hpp"

namespace voltlap::plant {

struct OutlinePoint {
  double distance_m, x_m, y_m;
};

/// Points from the start to the end of the course, at most `step_m` > 0 apart. Exact on arcs, not only to first
/// order.
[[nodiscard]] std::vector<OutlinePoint> outline(const Track& track, double step_m);

/// How far the end of the course lies from its start [m]; 0 for one that closes.
[[nodiscard]] double closing_gap_m(const Track& track);

/// Length and closing in words, for whoever reads a result.
[[nodiscard]] std::string course_text(double length_m, double gap_m);

}  // namespace voltlap::plant
