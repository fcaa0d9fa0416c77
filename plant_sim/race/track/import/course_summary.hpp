// SPDX-License-Identifier: Apache-2.0
// What a course is, in figures.
#pragma once
#include <cstddef>
#include <string>

#include "race/track/track.hpp"

namespace voltlap::plant {

struct CourseSummary {
  double length_m = 0.0;
  std::size_t corners = 0;         ///< stretches that turn one way, at radii below 100 m, by 10 degrees or more
  double straights_m = 0.0;        ///< length at radii of 100 m and more
  double tightest_radius_m = 0.0;  ///< 0 for a course without a corner
  double tightest_at_m = 0.0;      ///< where it begins, from the start
  double turned_deg = 0.0;         ///< to the right; 360 or -360 for a closed course that does not cross itself
  double climb_m = 0.0;            ///< sum of what rises
  double rise_m = 0.0;             ///< height of the end over the start
  double gap_m = 0.0;              ///< from the end of the course to its start, as its segments lie
};

[[nodiscard]] CourseSummary summarise(const Track& track);

/// The text of a course file that `load_track` reads as these segments, bit by bit; a curvature that no radius gives in
/// the one beside it. `head` are comment lines.
[[nodiscard]] std::string course_file_text(const Track& track, const std::string& head);

}  // namespace voltlap::plant
