// SPDX-License-Identifier: Apache-2.0
// The way along points in the order in which they were recorded, without their scatter: what lengths, laps and stops
// are read from. The course's curvature is found later, by fit_centre_line.
//
//   minimise sum |z_i - s_i|^2 + lambda sum |s_(i+3) - 3 s_(i+2) + 3 s_(i+1) - s_i|^2
//
// A straight, a circle's arc and an even acceleration cost next to nothing (Whittaker, 1923). lambda is the one that
// makes the points most likely (restricted likelihood): far apart and exact they stay, dense and noisy they are
// smoothed.
#pragma once
#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {

struct SmoothPath {
  PointList points;       ///< one for each point recorded
  double scatter_m = 0.0;  ///< standard deviation of the points about the path, in x and in y
};

/// At least 4 points.
[[nodiscard]] SmoothPath smooth_path(const PointList& recorded);

/// Distance from the first point to each along straight lines, and beyond the last the way back when `closed`.
[[nodiscard]] std::vector<double> distances_along(const PointList& path, bool closed);

/// Points of a path `step_m` apart or closer, evenly, along a smooth curve through its points (Catmull and Rom with
/// centripetal knots; Yuksel et al., 2011). The last point is the path's last; of a closed one that before the first.
[[nodiscard]] PointList evenly_spaced(const PointList& path, double step_m, bool closed);

}  // namespace voltlap::plant
