// SPDX-License-Identifier: Apache-2.0
// A course as a chain of segments of constant curvature (reference study, 2016, section 3.1.2).
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

struct Segment {
  double length_m;
  double curvature_per_m;  ///< 0 on a straight; positive turns right (z down, as in SAE J670)
  std::string place{};     ///< "file:line" that it came from, for messages
  double grade = 0.0;      ///< rise over distance, positive uphill
};

struct Track {
  std::string name;
  std::vector<Segment> segments;

  [[nodiscard]] double length_m() const;
};

/// Reads a track file. Two forms, told apart by their header:
///   straight_m,corner_radius_m,corner_angle_rad[,feature]   a straight, then an arc of radius x |angle|; or, in its
///                                                           place, corner_angle_deg
///   type,section_length_m,corner_radius_m                   Straight | Left | Right, a segment a row
/// Both may have a column grade_pct, the rise in percent of the distance.
/// Throws InputError with file and line for a negative length, a radius that is not positive, an angle beyond
/// a full circle, a missing column.
[[nodiscard]] Track load_track(const std::string& path);

}  // namespace voltlap::plant
