// SPDX-License-Identifier: Apache-2.0
// The laps in a recording: from the line back to the line.
#pragma once
#include <cstddef>
#include <vector>

#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {

struct Lap {
  std::size_t first, end;  ///< points of the path, from `first` to before `end`, the first behind the line again
  double length_m;
};

/// Whole laps of one course in a path that has no scatter, in order; empty when it is not driven round again. The
/// line lies where it cuts the most of the path into laps, at the first such place; laps lie within `reach_m` of each
/// other. A lap counts when the path, behind the line, follows the way of the first lap, and when its length is that of
/// the others within 5 %: a stretch that passes another one closely is none.
[[nodiscard]] std::vector<Lap> find_laps(const PointList& path, double reach_m);

}  // namespace voltlap::plant
