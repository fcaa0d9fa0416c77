// SPDX-License-Identifier: Apache-2.0
// A course seen from above, as an SVG picture: straights and corners in colours of their radius, the start with its
// direction, a scale, and the points that it came from.
#pragma once
#include <string>

#include "race/track/import/plane_point.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

/// The course as its segments lie from the origin along x; with `line`, the same course where its points lie. `points`
/// may be empty.
[[nodiscard]] std::string course_picture(const Track& track, const PointList& line, const PointList& points,
                                         const std::string& caption);

}  // namespace voltlap::plant
