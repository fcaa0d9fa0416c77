// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/exact_arcs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/demand.hpp"
#include "race/track/import/arc_pieces.hpp"

namespace voltlap::plant {
namespace {

constexpr double kGap_m = 4.0, kGapSteps = 3.0;  // between points, beyond which the line bridges
constexpr double kBridge_m = 1.5;                // arcs there, and of the line as a point on each
constexpr double kSameBend = 1e-4;               // 1/m, within which two curves touch nowhere
constexpr double kShortest_m = 0.02;
// Of the price of a piece: a bend between two straights that hardly differ needs the arcs beside it to be told.
constexpr std::array<double, 3> kPrices = {1.0, 0.5, 0.25};

double square(double v) { return v * v; }

/// Direction in which the distance from a curve does not change.
double heading_of(PlanePoint gradient) { return std::atan2(-gradient.x_m, gradient.y_m); }

class PiecesToArcs {
 public:
  PiecesToArcs(const NodeChain& line, double noise_m, double of_price) : line_(&line), noise_m_(noise_m) {
    course_.closed = line.closed();
    course_.noise_m = noise_m;
    course_.start = line.nodes().front();
    measure_line();
    order_points();
    pieces_ = cut_into_pieces(points_, line.closed(), noise_m, of_price);
    lay_arcs();
    part_straights();
    fit_course(course_, points_);
    VOLTLAP_DEMAND(!course_.arcs.empty());
  }

  [[nodiscard]] double information() const { return plant::information(course_, points_.size()); }

  ArcCourse searched(const ArcSearchOptions& options) {
    if (bends_all_along()) return std::move(course_);
    return search_arcs(std::move(course_), points_, options);
  }

 private:
  struct Station {
    double along_m;
    PlanePose pose;
  };

  /// A course drawn as a smooth curve is one bend after another: 8 of 10 joints, of straights and arcs 1 in 2 at most.
  [[nodiscard]] bool bends_all_along() const {
    std::size_t bends_in_a_row = 0;
    for (std::size_t k = 1; k < course_.arcs.size(); ++k) {
      bends_in_a_row += !course_.arcs[k - 1].arc.straight && !course_.arcs[k].arc.straight;
    }
    return 3 * bends_in_a_row > 2 * course_.arcs.size();
  }

  // along the line ----------------------------------------------------------------------------------------------------
  void measure_line() {
    node_along_m_.push_back(0.0);
    for (const double length_m : line_->arc_lengths()) node_along_m_.push_back(node_along_m_.back() + length_m);
  }
  [[nodiscard]] double length_m() const { return node_along_m_.back(); }

  [[nodiscard]] PlanePose pose_at_node(std::size_t node) const {
    const PlanePoint way = line_->nodes()[line_->next(node)] - line_->nodes()[line_->before(node)];
    return {line_->nodes()[node], std::atan2(way.y_m, way.x_m)};
  }

  [[nodiscard]] Station on_line(double along_m) const {
    const double at = line_->closed() ? along_m - length_m() * std::floor(along_m / length_m()) : along_m;
    const auto above = std::upper_bound(node_along_m_.begin() + 1, node_along_m_.end() - 1, at);
    const auto edge = static_cast<std::size_t>(above - node_along_m_.begin()) - 1;
    const double share = (at - node_along_m_[edge]) / (node_along_m_[edge + 1] - node_along_m_[edge]);
    const PlanePose from = pose_at_node(edge), to = pose_at_node(line_->next(edge));
    const double turn = std::remainder(to.heading_rad - from.heading_rad, 2.0 * M_PI);
    return {along_m, {(1.0 - share) * from.at + share * to.at, from.heading_rad + share * turn}};
  }

  void order_points() {
    const auto along = [&](const PointOffset& offset) {
      const std::size_t edge = offset.node[0];
      return node_along_m_[edge] - offset.slope[1] * (node_along_m_[edge + 1] - node_along_m_[edge]);
    };
    std::vector<std::size_t> order(line_->offsets().size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return along(line_->offsets()[a]) < along(line_->offsets()[b]);
    });
    for (const std::size_t i : order) {
      const PointOffset& offset = line_->offsets()[i];
      points_.push_back({line_->points()[offset.point], offset.weight});
      along_m_.push_back(along(offset));
    }
  }
  /// Beyond the number of points: of the next round.
  [[nodiscard]] double along_of(std::size_t i) const {
    const std::size_t n = along_m_.size();
    return along_m_[i % n] + static_cast<double>(i / n) * length_m();
  }

  // from piece to piece -----------------------------------------------------------------------------------------------
  /// The nearest place on a piece's curve, where its points tell one.
  [[nodiscard]] static Station drawn_to(const PointPiece& piece, const Station& by) {
    if (!piece.determined()) return by;
    PlanePoint at = by.pose.at;
    for (int step = 0; step < 2; ++step) {
      const PlanePoint gradient = piece.curve.gradient(at);
      at = at - (piece.curve.at(at) / dot(gradient, gradient)) * gradient;
    }
    return {by.along_m, {at, heading_of(piece.curve.gradient(at))}};
  }

  /// Where one piece ends and the next begins: where their curves touch, as their gradients are the same there.
  [[nodiscard]] Station between(const PointPiece& piece, const PointPiece& next) const {
    const double from_m = along_of(piece.end - 1), to_m = along_of(piece.end);
    const Station middle = on_line(0.5 * (from_m + to_m));
    const PlaneCurve &a = piece.curve, &b = next.curve;
    if (piece.determined() && next.determined() && std::abs(a.bend - b.bend) > kSameBend) {
      const PlanePoint touch = (0.5 / (a.bend - b.bend)) * (2.0 * a.bend * a.about - a.slope -
                                                            (2.0 * b.bend * b.about - b.slope));
      const PlanePoint off = touch - middle.pose.at, ahead = middle.pose.ahead();
      if (length(off) < to_m - from_m) {
        return {middle.along_m + dot(off, ahead), {touch, heading_of(a.gradient(touch) + b.gradient(touch))}};
      }
    }
    return drawn_to(next, drawn_to(piece, middle));
  }

  void add_arc(const PointPiece* piece, const Station& from, const Station& to) {
    const PlanePoint way = to.pose.at - from.pose.at;
    const double chord_m = std::max(kShortest_m, length(way)), along_m = to.along_m - from.along_m;
    Arc arc{chord_m, 0.0, piece && piece->straight && piece->determined()};
    if (!arc.straight) {
      const double expected = piece && piece->determined() ? piece->curve.curvature_per_m() * along_m : 0.0;
      const double turn = expected + std::remainder(to.pose.heading_rad - from.pose.heading_rad - expected, 2.0 * M_PI);
      const double share = sinc(0.5 * turn);
      arc.length_m = share > 0.3 ? chord_m / share : std::max(kShortest_m, along_m);
      arc.curvature_per_m = turn / arc.length_m;
    }
    PlacedArc placed{arc, from.pose, {}};
    if (piece) {
      for (std::size_t i = piece->first; i < piece->end; ++i) placed.points.push_back(i % along_m_.size());
    }
    course_.arcs.push_back(std::move(placed));
  }

  /// Where there are no points, short arcs along the line, each weakly held to it.
  void bridge(Station from, double to_m) {
    const int arcs = std::max(1, static_cast<int>((to_m - from.along_m) / kBridge_m));
    const double step_m = (to_m - from.along_m) / arcs;
    for (int k = 0; k < arcs; ++k) {
      const Station to = on_line(from.along_m + step_m);
      add_arc(nullptr, from, to);
      course_.arcs.back().points.push_back(points_.size());
      points_.push_back({on_line(from.along_m + 0.5 * step_m).pose.at, square(noise_m_ / kBridge_m)});
      from = to;
    }
  }

  [[nodiscard]] double widest_gap_m() const {
    const double mean_m = length_m() / static_cast<double>(along_m_.size());
    return std::max(kGap_m, kGapSteps * mean_m);
  }

  void lay_arcs() {
    const double gap_m = widest_gap_m();
    const PointPiece& first = pieces_.front();
    const auto gap_behind = [&](const PointPiece& piece) {
      return along_of(piece.end) - along_of(piece.end - 1) > gap_m;
    };
    const bool closed = line_->closed();
    Station from = drawn_to(first, on_line(0.0));
    if (closed) {
      PointPiece last = pieces_.back();
      const double begins_m = along_of(first.first);
      from = gap_behind(last) ? drawn_to(first, on_line(begins_m)) : between(last, first);
      from.along_m -= length_m() * std::round((from.along_m - begins_m) / length_m());
    }
    const Station start = from;
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const PointPiece& piece = pieces_[k];
      const bool last = k + 1 == pieces_.size();
      const PointPiece& next = pieces_[last ? 0 : k + 1];
      if (last && !closed) {
        const Station end = drawn_to(piece, on_line(length_m()));
        add_arc(&piece, from, end);
        course_.end = end.pose;
      } else if (gap_behind(piece)) {
        const Station to = drawn_to(piece, on_line(along_of(piece.end - 1)));
        add_arc(&piece, from, to);
        bridge(to, along_of(piece.end));
        from = last ? start : drawn_to(next, on_line(along_of(piece.end)));
      } else {
        Station to = last ? start : between(piece, next);
        if (last) to.along_m += length_m();
        add_arc(&piece, from, to);
        from = to;
      }
    }
  }

  /// Of two straights in a row, which do not go on from one another, the shorter may bend.
  void part_straights() {
    for (std::size_t k = 0; k + (course_.closed ? 0 : 1) < course_.arcs.size(); ++k) {
      Arc &a = course_.arcs[k].arc, &b = course_.arcs[(k + 1) % course_.arcs.size()].arc;
      if (a.straight && b.straight) (a.length_m < b.length_m ? a : b).straight = false;
    }
  }

  const NodeChain* line_;
  double noise_m_;
  ArcCourse course_;
  std::vector<WeightedPoint> points_;  ///< in order along the line; bridges behind them
  std::vector<double> along_m_;        ///< of the points
  std::vector<double> node_along_m_;
  std::vector<PointPiece> pieces_;
};

}  // namespace

ArcCourse find_exact_arcs(const NodeChain& line, double noise_m, const ArcSearchOptions& options) {
  VOLTLAP_DEMAND(line.size() >= 2 && !line.offsets().empty() && noise_m > 0.0);
  PiecesToArcs best(line, noise_m, kPrices.front());
  for (std::size_t k = 1; k < kPrices.size(); ++k) {
    PiecesToArcs other(line, noise_m, kPrices[k]);
    if (other.information() < best.information()) best = std::move(other);
  }
  return best.searched(options);
}

}  // namespace voltlap::plant
