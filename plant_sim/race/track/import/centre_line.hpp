// SPDX-License-Identifier: Apache-2.0
// A course as straights and arcs from points that lie about it.
//
// With e_i the distance of point i across the line, sigma the points' noise and kappa_j the curvature at node j:
//
//   minimise  sum (e_i / sigma)^2 + sum ((kappa_(j+1) - kappa_j) / q_j)^2       by Gauss-Newton
//
// 1. Even: one q for all; sigma and q are the ones that make the points most likely (restricted likelihood).
// 2. Own: each place learns its q_j, q_j^2 = E[(kappa_(j+1) - kappa_j)^2] with the uncertainty of the estimate
//    (automatic relevance determination: MacKay, 1992; Tipping, 2001). Changes gather where corners begin and end.
// 3. Arcs: the curvature changes at those places only. Places move to where the points want them, and one whose
//    change the points do not support, change^2 / variance below a bound, is taken out until all are supported: noise
//    is not taken for corners, and hairpins keep the radius that an even smoothing widens.
//
// Points whose noise is below 2 cm get their arcs from find_exact_arcs instead of stages 2 and 3: an even line through
// them rings where a corner begins.
//
// The even line is the result where the arcs explain the points clearly worse (Schwarz' information), and where they
// turn otherwise than it does. Of exact points it is, too, where the arcs do not go on from one another or are of
// another length: a course that was drawn as a smooth curve lies off as many arcs as it may be cut into.
//
// Only the distance across the line counts: neither speed nor spacing matter, and points of several laps give their
// mean.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "race/track/import/arc_chain.hpp"

namespace voltlap::plant {

/// Noise of the points across the course: measured from the points unless it is given.
struct CentreLineOptions {
  bool closed = true;
  double noise_m = -1.0;  ///< below 0: measured
  bool arcs = true;       ///< not the even line alone
  std::function<void(double)> progress{};  ///< share done, 0 to 1
};

struct CentreLine {
  std::vector<Arc> arcs;
  PointList nodes;  ///< for drawing
  double noise_m = 0.0;
  std::size_t points_used = 0;
  bool of_segments = false;  ///< straights and arcs; not the even line
};

/// `start`: nodes along the course, even, which the points lie about. `points` in order along it, lap after lap.
[[nodiscard]] CentreLine fit_centre_line(const PointList& start, const PointList& points,
                                         const CentreLineOptions& options);

}  // namespace voltlap::plant
