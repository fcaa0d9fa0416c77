// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/arc_chain.hpp"

#include <cmath>

namespace voltlap::plant {

double sinc(double x) { return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x; }

PlanePose end_of(const Arc& arc, const PlanePose& from) {
  const double turn = arc.curvature_per_m * arc.length_m, along = from.heading_rad + 0.5 * turn;
  const double chord = arc.length_m * sinc(0.5 * turn);
  return {from.at + chord * PlanePoint{std::cos(along), std::sin(along)}, from.heading_rad + turn};
}

Foot foot_of(PlanePoint point, const Arc& arc, const PlanePose& from, PlanePoint ahead) {
  const PlanePoint away = point - from.at;
  const double u = dot(away, ahead), v = cross(ahead, away), c = arc.curvature_per_m;
  const double beside = c * u, behind = 1.0 - c * v, to_centre = std::sqrt(beside * beside + behind * behind);
  // r - sqrt(u^2 + (v - r)^2) without the difference of two large numbers.
  const double offset = (2.0 * v - c * (u * u + v * v)) / (1.0 + to_centre);
  if (std::abs(c) < 1e-9 || to_centre < 1e-9) return {u, offset, 0.0, 0.0, 1.0};
  // Of all rounds the angle that is nearest to the middle of the arc.
  const double middle = 0.5 * c * arc.length_m;
  double turn = std::atan2(beside, behind);
  while (turn - middle > M_PI) turn -= 2.0 * M_PI;
  while (turn - middle < -M_PI) turn += 2.0 * M_PI;
  return {turn / c, offset, turn, beside / to_centre, behind / to_centre};
}

void ArcEquations::add(const Foot& foot, double weight) {
  const bool bent = std::abs(foot.turn_rad) > 1e-3;
  const double arm = bent ? foot.sine / foot.turn_rad : 1.0 - foot.turn_rad * foot.turn_rad / 6.0;
  const double bend = bent ? (1.0 - foot.cosine) / (foot.turn_rad * foot.turn_rad) : 0.5;
  const std::array<double, 4> slope = {foot.sine, -foot.cosine, -foot.along_m * arm,
                                       -foot.along_m * foot.along_m * bend};
  for (std::size_t a = 0; a < 4; ++a) {
    right[a] -= weight * slope[a] * foot.offset_m;
    for (std::size_t b = 0; b < 4; ++b) square[a][b] += weight * slope[a] * slope[b];
  }
}

EndSlopes end_slopes_of(const Arc& arc) {
  const double length = arc.length_m, turn = arc.curvature_per_m * length, s = std::sin(turn), c = std::cos(turn);
  EndSlopes end{length * sinc(turn), length * sinc(0.5 * turn) * std::sin(0.5 * turn), turn, 0.0, 0.0};
  const double square = length * length;
  if (std::abs(turn) > 1e-3) {
    end.ahead_by_curvature = (turn * c - s) * square / (turn * turn);
    end.left_by_curvature = (turn * s - 1.0 + c) * square / (turn * turn);
  } else {
    end.ahead_by_curvature = -square * turn / 3.0;
    end.left_by_curvature = 0.5 * square;
  }
  return end;
}

}  // namespace voltlap::plant
