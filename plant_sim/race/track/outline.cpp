// SPDX-License-Identifier: Apache-2.0
#include "race/track/outline.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// Chord over arc: sin(a) / a for half the turned angle.
double chord_ratio(double half_turn) {
  return std::abs(half_turn) < 1e-9 ? 1.0 : std::sin(half_turn) / half_turn;
}

}  // namespace

std::vector<OutlinePoint> outline(const Track& track, double step_m) {
  VOLTLAP_DEMAND(step_m > 0.0);
  std::vector<OutlinePoint> points{{0.0, 0.0, 0.0}};
  double heading = 0.0;
  for (const Segment& segment : track.segments) {
    const int pieces = std::max(1, static_cast<int>(std::ceil(segment.length_m / step_m)));
    const double length = segment.length_m / pieces, half_turn = -0.5 * segment.curvature_per_m * length;
    for (int i = 0; i < pieces; ++i) {
      const OutlinePoint from = points.back();
      const double chord = length * chord_ratio(half_turn), along = heading + half_turn;
      points.push_back(
          {from.distance_m + length, from.x_m + chord * std::cos(along), from.y_m + chord * std::sin(along)});
      heading += 2.0 * half_turn;
    }
  }
  VOLTLAP_DEMAND(points.size() > track.segments.size());
  return points;
}

double closing_gap_m(const Track& track) {
  const OutlinePoint end = outline(track, track.length_m() + 1.0).back();
  return std::hypot(end.x_m, end.y_m);
}

std::string course_text(double length_m, double gap_m) {
  constexpr double kClosed = 0.005;  // of the length: what rounded radii and angles add up to
  const std::string length = fmt::format("{:.1f} m", length_m);
  if (gap_m <= kClosed * length_m) return length + ", closed";
  return length + fmt::format(", its end {:.0f} m away from its start: driven as a lap all the same", gap_m);
}

}  // namespace voltlap::plant
