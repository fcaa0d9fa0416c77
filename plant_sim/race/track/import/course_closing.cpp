// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_closing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "race/track/import/banded_system.hpp"
#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {
namespace {

constexpr double kAngle_rad = 0.01, kLength_m = 0.1;
constexpr double kMostChange = 0.3;  // of a segment's length or angle
constexpr int kRounds = 8;

double square(double v) { return v * v; }

struct Pose {
  PlanePoint at{};
  double heading = 0.0;
  [[nodiscard]] PlanePoint along() const { return {std::cos(heading), std::sin(heading)}; }
};

/// End of a segment; the angle turned is that of its curvature, to the left here.
Pose after(const Pose& from, double length, double turn) {
  const double half = 0.5 * turn, chord = length * (std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half);
  const double along = from.heading + half;
  return {from.at + chord * PlanePoint{std::cos(along), std::sin(along)}, from.heading + turn};
}

using Conditions = std::array<double, 3>;  // x, y, direction

/// What the course misses, and how it depends on angle and length of each segment.
struct Misses {
  Conditions missed{};
  std::vector<Conditions> by_angle, by_length;
};

Misses misses_of(const std::vector<Segment>& segments) {
  std::vector<Pose> ends{{}};
  for (const Segment& s : segments) ends.push_back(after(ends.back(), s.length_m, -s.curvature_per_m * s.length_m));
  const Pose last = ends.back();
  const double rounds = std::round(last.heading / (2.0 * M_PI));
  Misses out{{last.at.x_m, last.at.y_m, last.heading - 2.0 * M_PI * rounds}, {}, {}};
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const double length_m = segments[k].length_m, turn = -segments[k].curvature_per_m * length_m;
    const PlanePoint rest = left_of(last.at - ends[k + 1].at);
    // At a fixed length: by differences, exact to second order.
    const double step = 1e-5;
    const PlanePoint more = after(ends[k], length_m, turn + step).at, less = after(ends[k], length_m, turn - step).at;
    const PlanePoint bend = (0.5 / step) * (more - less);
    const PlanePoint chord = (1.0 / length_m) * (ends[k + 1].at - ends[k].at);
    out.by_angle.push_back({bend.x_m + rest.x_m, bend.y_m + rest.y_m, 1.0});
    out.by_length.push_back({chord.x_m, chord.y_m, 0.0});
  }
  return out;
}

/// Lagrange's multipliers of the three conditions.
std::vector<double> multipliers(const Misses& m, const std::vector<Segment>& segments) {
  BandedSystem system(3, 2);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const double angle2 = segments[k].curvature_per_m == 0.0 ? 0.0 : square(kAngle_rad);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        system.add(i, j, angle2 * m.by_angle[k][i] * m.by_angle[k][j] +
                             square(kLength_m) * m.by_length[k][i] * m.by_length[k][j]);
      }
    }
  }
  if (!system.factorise()) return {};
  return system.solved({-m.missed[0], -m.missed[1], -m.missed[2]});
}

}  // namespace

std::vector<Segment> closed_segments(const std::vector<Segment>& segments) {
  VOLTLAP_DEMAND(!segments.empty());
  std::vector<Segment> closed = segments;
  for (int round = 0; round < kRounds; ++round) {
    const Misses misses = misses_of(closed);
    const std::vector<double> pull = multipliers(misses, closed);
    if (pull.empty()) return segments;
    for (std::size_t k = 0; k < closed.size(); ++k) {
      double angle = 0.0, length = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        angle += square(kAngle_rad) * misses.by_angle[k][i] * pull[i];
        length += square(kLength_m) * misses.by_length[k][i] * pull[i];
      }
      Segment& s = closed[k];
      const double turned = s.curvature_per_m * s.length_m;
      if (std::abs(length) > kMostChange * s.length_m) return segments;
      s.length_m += length;
      if (turned == 0.0) continue;
      if (std::abs(angle) > kMostChange * std::max(0.1, std::abs(turned))) return segments;
      s.curvature_per_m = (turned - angle) / s.length_m;
    }
  }
  VOLTLAP_DEMAND(closed.size() == segments.size());
  return closed;
}

}  // namespace voltlap::plant
