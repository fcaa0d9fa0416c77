// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/demand.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant {
namespace {

constexpr double kCornerRadius_m = 100.0;
constexpr double kCornerTurn_rad = 10.0 * M_PI / 180.0;
constexpr double kOutlineStep_m = 1.0;

/// The radius r with 1 / r == |curvature| to the last bit, as reading it computes; none is further than a few steps off.
double radius_of(double curvature) {
  const double size = std::abs(curvature), near = 1.0 / size;
  double below = near, above = near;
  for (int step = 0; step < 4; ++step) {
    if (1.0 / below == size) return below;
    if (1.0 / above == size) return above;
    below = std::nextafter(below, 0.0);
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
  }
  return near;
}

}  // namespace

CourseSummary summarise(const Track& track) {
  VOLTLAP_DEMAND(!track.segments.empty());
  CourseSummary sum;
  double turn = 0.0;  // of the corner that is being driven
  const auto end_corner = [&] {
    if (std::abs(turn) >= kCornerTurn_rad) ++sum.corners;
    turn = 0.0;
  };
  double sharpest = 0.0;
  for (const Segment& segment : track.segments) {
    const double curvature = segment.curvature_per_m, angle = curvature * segment.length_m;
    const bool bends = std::abs(curvature) > 1.0 / kCornerRadius_m;
    if (!bends || turn * curvature < 0.0) end_corner();
    if (bends) turn += angle;
    else sum.straights_m += segment.length_m;
    if (bends && std::abs(curvature) > sharpest) {
      sharpest = std::abs(curvature);
      sum.tightest_at_m = sum.length_m;
    }
    sum.length_m += segment.length_m;
    sum.turned_deg += angle * 180.0 / M_PI;
  }
  end_corner();
  sum.tightest_radius_m = sharpest > 0.0 ? 1.0 / sharpest : 0.0;
  const OutlinePoint end = outline(track, kOutlineStep_m).back();
  sum.gap_m = std::hypot(end.x_m, end.y_m);
  VOLTLAP_DEMAND(std::isfinite(sum.gap_m) && sum.length_m > 0.0);
  return sum;
}

std::string course_file_text(const Track& track, const std::string& head) {
  std::string text = head + "type,section_length_m,corner_radius_m\n";
  for (const Segment& segment : track.segments) {
    const double curvature = segment.curvature_per_m;
    if (curvature == 0.0) text += fmt::format("Straight,{},0\n", segment.length_m);
    else text += fmt::format("{},{},{}\n", curvature < 0.0 ? "Left" : "Right", segment.length_m, radius_of(curvature));
  }
  return text;
}

}  // namespace voltlap::plant
