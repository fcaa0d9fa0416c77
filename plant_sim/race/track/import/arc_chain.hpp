// SPDX-License-Identifier: Apache-2.0
// Straights and arcs in the plane, each going on in the direction in which the one before it ended, and how far points
// lie off them.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {

struct Arc {
  double length_m, curvature_per_m;  ///< curvature above 0 turns left
  bool straight = false;             ///< curvature is 0 and stays so
};

struct PlanePose {
  PlanePoint at{};
  double heading_rad = 0.0;
  [[nodiscard]] PlanePoint ahead() const { return {std::cos(heading_rad), std::sin(heading_rad)}; }
};

/// End of the arc that begins at `from`.
[[nodiscard]] PlanePose end_of(const Arc& arc, const PlanePose& from);

/// Place on an arc, prolonged beyond both of its ends, that is nearest to a point.
struct Foot {
  double along_m;   ///< from the start of the arc
  double offset_m;  ///< from there to the point, above 0 to the left
  double turn_rad, sine, cosine;  ///< turned from the start to there
};
/// `ahead`: that of `from`, which is worked out once for many points.
[[nodiscard]] Foot foot_of(PlanePoint point, const Arc& arc, const PlanePose& from, PlanePoint ahead);

/// sin(x) / x.
[[nodiscard]] double sinc(double x);

struct WeightedPoint {
  PlanePoint at;
  double weight;
};

struct PlacedArc {
  Arc arc;
  PlanePose from;
  std::vector<std::size_t> points;  ///< that lie beside it
};

/// A closed course ends where its first arc begins, an open one at `end`.
struct ArcCourse {
  std::vector<PlacedArc> arcs;
  PlanePose end;
  bool closed = true;
  double noise_m = 0.0;
  PlanePoint start{};    ///< beside which a closed one shall begin
  bool meets = false;    ///< each arc begins where the one before ends; set by the search, too
  double squares = 0.0;  ///< of the points' distances, weighted, m^2; set by the search
};

/// Normal equations of the points beside an arc in what moves it: along, to the left and heading at its start, and its
/// curvature.
struct ArcEquations {
  std::array<std::array<double, 4>, 4> square{};
  std::array<double, 4> right{};

  void add(const Foot& foot, double weight);
};

/// End of an arc in the frame of its start, and how it moves with the curvature.
struct EndSlopes {
  double ahead_m, left_m, turn_rad, ahead_by_curvature, left_by_curvature;
};
[[nodiscard]] EndSlopes end_slopes_of(const Arc& arc);

}  // namespace voltlap::plant
