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

/// The number near `about` that `read` makes exactly `wanted` of; `about` where there is none.
template <class Read>
double written(double about, double wanted, const Read& read) {
  double below = about, above = about;
  for (int step = 0; step < 4; ++step) {
    if (read(below) == wanted) return below;
    if (read(above) == wanted) return above;
    below = std::nextafter(below, -std::numeric_limits<double>::infinity());
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
  }
  return about;
}

double radius_of(double curvature) {
  const double size = std::abs(curvature);
  return written(1.0 / size, size, [](double radius) { return 1.0 / radius; });
}

double percent_of(double grade) {
  return written(100.0 * grade, grade, [](double percent) { return 0.01 * percent; });
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
    sum.climb_m += std::max(0.0, segment.grade * segment.length_m);
    sum.rise_m += segment.grade * segment.length_m;
    sum.turned_deg += angle * 180.0 / M_PI;
  }
  end_corner();
  sum.tightest_radius_m = sharpest > 0.0 ? 1.0 / sharpest : 0.0;
  sum.gap_m = closing_gap_m(track);
  VOLTLAP_DEMAND(std::isfinite(sum.gap_m) && sum.length_m > 0.0);
  return sum;
}

std::string course_file_text(const Track& track, const std::string& head) {
  const bool graded = std::any_of(track.segments.begin(), track.segments.end(),
                                  [](const Segment& segment) { return segment.grade != 0.0; });
  std::string text = head + "type,section_length_m,corner_radius_m" + (graded ? ",grade_pct\n" : "\n");
  for (const Segment& segment : track.segments) {
    const double curvature = segment.curvature_per_m;
    const char* type = curvature == 0.0 ? "Straight" : curvature < 0.0 ? "Left" : "Right";
    text += fmt::format("{},{},{}", type, segment.length_m, curvature == 0.0 ? 0.0 : radius_of(curvature));
    text += graded ? fmt::format(",{}\n", percent_of(segment.grade)) : "\n";
  }
  return text;
}

}  // namespace voltlap::plant
