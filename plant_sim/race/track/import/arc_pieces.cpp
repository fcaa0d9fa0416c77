// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/arc_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kFiguresOfStraight = 3.0, kFiguresOfCircle = 4.0;
constexpr int kNewtonSteps = 20;

double square(double v) { return v * v; }

/// Symmetric, of |p|^2 (scaled to the size of the others), x and y about the points' centre.
using Spread = std::array<std::array<double, 3>, 3>;

/// Weighted sums over points, of their places from the first.
class Moments {
 public:
  explicit Moments(PlanePoint origin) : origin_(origin) {}

  void add(const WeightedPoint& point) {
    const PlanePoint p = point.at - origin_;
    const double w = point.weight, z = dot(p, p);
    w_ += w, x_ += w * p.x_m, y_ += w * p.y_m, z_ += w * z;
    xx_ += w * p.x_m * p.x_m, xy_ += w * p.x_m * p.y_m, yy_ += w * p.y_m * p.y_m;
    xz_ += w * p.x_m * z, yz_ += w * p.y_m * z, zz_ += w * z * z;
  }

  [[nodiscard]] double weight() const { return w_; }
  [[nodiscard]] PlanePoint centre() const { return origin_ + PlanePoint{x_ / w_, y_ / w_}; }

  /// `mean_square_m2`: of the distance from the centre.
  [[nodiscard]] Spread spread(double& mean_square_m2) const {
    const double mx = x_ / w_, my = y_ / w_, mz = z_ / w_;
    const double xx = xx_ / w_ - mx * mx, xy = xy_ / w_ - mx * my, yy = yy_ / w_ - my * my;
    const double xz0 = xz_ / w_ - mx * mz, yz0 = yz_ / w_ - my * mz, zz0 = zz_ / w_ - mz * mz;
    const double xz = xz0 - 2.0 * (mx * xx + my * xy), yz = yz0 - 2.0 * (mx * xy + my * yy);
    const double zz = zz0 - 4.0 * (mx * xz0 + my * yz0) + 4.0 * (mx * mx * xx + 2.0 * mx * my * xy + my * my * yy);
    mean_square_m2 = xx + yy;
    const double scale = 1.0 / (2.0 * std::sqrt(std::max(1e-300, mean_square_m2)));
    return {{{zz * scale * scale, xz * scale, yz * scale}, {xz * scale, xx, xy}, {yz * scale, xy, yy}}};
  }

 private:
  PlanePoint origin_;
  double w_ = 0.0, x_ = 0.0, y_ = 0.0, z_ = 0.0, xx_ = 0.0, xy_ = 0.0, yy_ = 0.0, xz_ = 0.0, yz_ = 0.0, zz_ = 0.0;
};

double least_eigenvalue_of_straights(const Spread& s) {
  const double half_sum = 0.5 * (s[1][1] + s[2][2]), determinant = s[1][1] * s[2][2] - square(s[1][2]);
  const double root = std::sqrt(square(0.5 * (s[1][1] - s[2][2])) + square(s[1][2]));
  return std::max(0.0, determinant / std::max(1e-300, half_sum + root));
}

/// Newton from 0, from where it does not step over the least.
double least_eigenvalue(const Spread& s) {
  const double sum = s[0][0] + s[1][1] + s[2][2];
  const double minors = s[0][0] * s[1][1] - square(s[0][1]) + s[0][0] * s[2][2] - square(s[0][2]) +
                        s[1][1] * s[2][2] - square(s[1][2]);
  const double determinant = s[0][0] * (s[1][1] * s[2][2] - square(s[1][2])) -
                             s[0][1] * (s[0][1] * s[2][2] - s[1][2] * s[0][2]) +
                             s[0][2] * (s[0][1] * s[1][2] - s[1][1] * s[0][2]);
  double value = 0.0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double at = determinant - value * (minors - value * (sum - value));
    const double slope = -minors + value * (2.0 * sum - 3.0 * value);
    if (at <= 0.0 || slope >= 0.0) break;
    const double by = -at / slope;
    value += by;
    if (by < 1e-6 * value) break;
  }
  return value;
}

std::array<double, 3> eigenvector(const Spread& s, double value) {
  std::array<double, 3> best{};
  double longest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, 3> a = s[i], b = s[(i + 1) % 3];
    a[i] -= value;
    b[(i + 1) % 3] -= value;
    const std::array<double, 3> c = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double size = std::sqrt(square(c[0]) + square(c[1]) + square(c[2]));
    if (size > longest) longest = size, best = c;
  }
  for (double& v : best) v /= std::max(1e-300, longest);
  return best;
}

struct Judged {
  double cost;
  bool straight;
};

class PieceSearch {
 public:
  PieceSearch(const std::vector<WeightedPoint>& points, double noise_m, double of_price)
      : points_(points), per_square_(1.0 / square(noise_m)),
        price_of_figure_(of_price * std::log(static_cast<double>(points.size()))) {}

  std::vector<PointPiece> run(std::size_t first) {
    const std::size_t n = points_.size();
    std::vector<double> least(n + 1, 0.0);
    std::vector<PointPiece> best(n + 1);
    struct Start {
      std::size_t first;
      Moments moments;
      double without_price;
    };
    std::vector<Start> starts;
    for (std::size_t end = 1; end <= n; ++end) {
      starts.push_back({end - 1, Moments(point(first + end - 1).at), 0.0});
      least[end] = std::numeric_limits<double>::max();
      for (Start& start : starts) {
        start.moments.add(point(first + end - 1));
        const Judged judged = judge(start.moments, end - start.first, start.without_price);
        const double cost = least[start.first] + judged.cost;
        if (cost < least[end]) least[end] = cost, best[end] = {start.first, end, judged.straight, {}};
      }
      std::erase_if(starts, [&](const Start& s) { return least[s.first] + s.without_price >= least[end]; });
    }
    std::vector<PointPiece> pieces;
    for (std::size_t end = n; end > 0; end = best[end].first) pieces.push_back(best[end]);
    std::reverse(pieces.begin(), pieces.end());
    for (PointPiece& piece : pieces) {
      piece.first += first, piece.end += first;
      piece.curve = curve_through(piece);
    }
    return pieces;
  }

 private:
  [[nodiscard]] const WeightedPoint& point(std::size_t i) const { return points_[i % points_.size()]; }

  /// `without_price`: of the better of the two kinds, which a longer piece cannot fall below.
  [[nodiscard]] Judged judge(const Moments& moments, std::size_t count, double& without_price) const {
    const double price = kFiguresOfStraight * price_of_figure_, more = kFiguresOfCircle * price_of_figure_;
    without_price = 0.0;
    if (count <= 2) return {price, true};
    double mean_square = 0.0;
    const Spread spread = moments.spread(mean_square);
    const double scale = moments.weight() * per_square_;
    const double straight = scale * least_eigenvalue_of_straights(spread);
    const double circle = count == 3 ? 0.0 : std::min(straight, scale * least_eigenvalue(spread));
    without_price = circle;
    return straight + price <= circle + more ? Judged{straight + price, true} : Judged{circle + more, false};
  }

  [[nodiscard]] PlaneCurve curve_through(const PointPiece& piece) const {
    Moments moments(point(piece.first).at);
    for (std::size_t i = piece.first; i < piece.end; ++i) moments.add(point(i));
    double mean_square = 0.0;
    Spread spread = moments.spread(mean_square);
    PlaneCurve curve{moments.centre(), {0.0, 1.0}};
    if (piece.end - piece.first < 2) return curve;
    if (piece.straight) {
      const double twice = 2.0 * spread[1][2], difference = spread[1][1] - spread[2][2];
      const double angle = 0.5 * std::atan2(twice, difference);
      curve.slope = {-std::sin(angle), std::cos(angle)};
    } else {
      const std::array<double, 3> v = eigenvector(spread, least_eigenvalue(spread));
      curve.bend = v[0] / (2.0 * std::sqrt(mean_square));
      curve.slope = {v[1], v[2]};
      curve.level = -curve.bend * mean_square;
    }
    return turned_along(curve, piece);
  }

  [[nodiscard]] PlaneCurve turned_along(PlaneCurve curve, const PointPiece& piece) const {
    double forward = 0.0;
    for (std::size_t i = piece.first; i + 1 < piece.end; ++i) {
      const PlanePoint from = point(i).at, to = point(i + 1).at;
      forward += cross(to - from, curve.gradient(0.5 * (from + to)));
    }
    if (forward < 0.0) curve = {curve.about, -1.0 * curve.slope, -curve.bend, -curve.level};
    return curve;
  }

  const std::vector<WeightedPoint>& points_;
  double per_square_, price_of_figure_;
};

}  // namespace

std::vector<PointPiece> cut_into_pieces(const std::vector<WeightedPoint>& points, bool closed, double noise_m,
                                        double of_price) {
  VOLTLAP_DEMAND(points.size() >= 2 && noise_m > 0.0 && of_price > 0.0);
  PieceSearch search(points, noise_m, of_price);
  std::vector<PointPiece> pieces = search.run(0);
  // Of a round course no piece is cut where the list begins: again from a cut that is far from there.
  if (closed && pieces.size() > 2) pieces = search.run(pieces[pieces.size() / 2].first);
  VOLTLAP_DEMAND(pieces.back().end - pieces.front().first == points.size());
  return pieces;
}

}  // namespace voltlap::plant
