// SPDX-License-Identifier: Apache-2.0
// Points in order along a course cut where one straight or circle ends and the next begins: of all ways to cut them the
// one of the least
//
//   sum over the pieces of  min( sum w e^2 / sigma^2 + price )  over straights and circles
//
// with the price of a piece by Schwarz (1978): ln(points) for each of its free figures, three of a straight and four of
// a circle, the place where it begins among them. Exact search with pruning: Killick, Fearnhead, Eckley (2012). Circles
// by Taubin (1991), whose least eigenvalue is the mean square of the distances.
//
// Nothing in it depends on how the course lies in the plane or which way round the points go.
#pragma once
#include <cstddef>
#include <vector>

#include "race/track/import/arc_chain.hpp"

namespace voltlap::plant {

/// F(p) = bend |p - about|^2 + slope (p - about) + level, the distance from the curve where it is small, above 0 to the
/// left of the way along it; |grad F| is 1 on the curve.
struct PlaneCurve {
  PlanePoint about{}, slope{};
  double bend = 0.0, level = 0.0;

  [[nodiscard]] double curvature_per_m() const { return -2.0 * bend; }  ///< above 0 turns left
  [[nodiscard]] double at(PlanePoint p) const {
    const PlanePoint away = p - about;
    return bend * dot(away, away) + dot(slope, away) + level;
  }
  [[nodiscard]] PlanePoint gradient(PlanePoint p) const { return 2.0 * bend * (p - about) + slope; }
};

struct PointPiece {
  std::size_t first, end;  ///< indices of the points; a piece across the end of the list has end > their number
  bool straight = false;
  PlaneCurve curve{};
  /// More points than go through any such curve.
  [[nodiscard]] bool determined() const { return end - first > (straight ? 2U : 3U); }
};

/// `of_price`: below 1 for more pieces than the points alone bear out.
[[nodiscard]] std::vector<PointPiece> cut_into_pieces(const std::vector<WeightedPoint>& points, bool closed,
                                                      double noise_m, double of_price = 1.0);

}  // namespace voltlap::plant
