// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/smooth_path.hpp"

#include <algorithm>
#include <array>

#include "core/demand.hpp"
#include "race/track/import/banded_system.hpp"
#include "race/track/import/golden_section.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<double, 4> kThirdDifference = {-1.0, 3.0, -3.0, 1.0};

class Whittaker {
 public:
  explicit Whittaker(const PointList& recorded) : recorded_(recorded), system_(recorded.size(), 3) {}

  /// -2 log of the restricted likelihood; keeps path and scatter.
  double misfit(double log10_weight) {
    const double weight = std::pow(10.0, log10_weight);
    const std::size_t n = recorded_.size();
    system_.clear();
    for (std::size_t i = 0; i < n; ++i) system_.add(i, i, 1.0);
    for (std::size_t i = 0; i + 3 < n; ++i) {
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
          system_.add(i + a, i + b, weight * kThirdDifference[a] * kThirdDifference[b]);
        }
      }
    }
    VOLTLAP_DEMAND(system_.factorise());
    solve();
    const double free = static_cast<double>(n - 3);
    // (z - s) z = |z - s|^2 + lambda |D s|^2 at the minimum.
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += dot(recorded_[i] - path_.points[i], recorded_[i] - centre_);
    const double variance = std::max(sum, 1e-12 * free) / (2.0 * free);
    path_.scatter_m = std::sqrt(variance);
    return 2.0 * (free * std::log(variance) + system_.log_determinant() - free * std::log(weight));
  }
  [[nodiscard]] const SmoothPath& path() const { return path_; }

 private:
  void solve() {
    std::vector<double> x, y;
    for (const PlanePoint& p : recorded_) {
      x.push_back(p.x_m - centre_.x_m);
      y.push_back(p.y_m - centre_.y_m);
    }
    x = system_.solved(std::move(x));
    y = system_.solved(std::move(y));
    path_.points.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) path_.points[i] = centre_ + PlanePoint{x[i], y[i]};
  }

  const PointList& recorded_;
  const PlanePoint centre_ = recorded_[recorded_.size() / 2];
  BandedSystem system_;
  SmoothPath path_;
};

/// Point at `share` of the piece from b to c, with the neighbours a and d.
PlanePoint on_curve(const std::array<PlanePoint, 4>& p, double share) {
  std::array<double, 4> knot{};
  for (std::size_t k = 1; k < 4; ++k) knot[k] = knot[k - 1] + std::sqrt(std::max(1e-9, length(p[k] - p[k - 1])));
  const double t = knot[1] + share * (knot[2] - knot[1]);
  const auto mix = [&](PlanePoint a, PlanePoint b, std::size_t from, std::size_t to) {
    const double f = (t - knot[from]) / (knot[to] - knot[from]);
    return (1.0 - f) * a + f * b;
  };
  const PlanePoint a1 = mix(p[0], p[1], 0, 1), a2 = mix(p[1], p[2], 1, 2), a3 = mix(p[2], p[3], 2, 3);
  return mix(mix(a1, a2, 0, 2), mix(a2, a3, 1, 3), 1, 2);
}

/// The path with each piece cut into parts that are short against `step_m`.
PointList refined(const PointList& path, double step_m, bool closed) {
  const std::size_t n = path.size(), pieces = closed ? n : n - 1;
  const auto at = [&](std::size_t i, int offset) {
    const auto k = static_cast<long>(i) + offset, last = static_cast<long>(n) - 1;
    if (closed) return path[static_cast<std::size_t>((k + last + 1) % (last + 1))];
    if (k < 0) return 2.0 * path[0] - path[1];
    if (k > last) return 2.0 * path[n - 1] - path[n - 2];
    return path[static_cast<std::size_t>(k)];
  };
  PointList fine;
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::array<PlanePoint, 4> around = {at(i, -1), at(i, 0), at(i, 1), at(i, 2)};
    const auto parts = static_cast<std::size_t>(1.0 + 4.0 * length(around[2] - around[1]) / step_m);
    for (std::size_t k = 0; k < parts; ++k) {
      fine.push_back(on_curve(around, static_cast<double>(k) / static_cast<double>(parts)));
    }
  }
  if (!closed) fine.push_back(path.back());
  return fine;
}

}  // namespace

SmoothPath smooth_path(const PointList& recorded) {
  VOLTLAP_DEMAND(recorded.size() >= 4);
  Whittaker whittaker(recorded);
  const double best = golden_section(-6.0, 8.0, 0.05, [&](double weight) { return whittaker.misfit(weight); });
  whittaker.misfit(best);
  VOLTLAP_DEMAND(whittaker.path().points.size() == recorded.size());
  return whittaker.path();
}

std::vector<double> distances_along(const PointList& path, bool closed) {
  VOLTLAP_DEMAND(!path.empty());
  std::vector<double> along{0.0};
  for (std::size_t i = 1; i < path.size(); ++i) along.push_back(along.back() + length(path[i] - path[i - 1]));
  if (closed) along.push_back(along.back() + length(path.front() - path.back()));
  return along;
}

PointList evenly_spaced(const PointList& path, double step_m, bool closed) {
  VOLTLAP_DEMAND(path.size() >= 3 && step_m > 0.0);
  PointList fine = refined(path, step_m, closed);
  const std::vector<double> along = distances_along(fine, closed);
  if (closed) fine.push_back(fine.front());
  const auto pieces = static_cast<std::size_t>(std::ceil(along.back() / step_m));
  PointList even;
  std::size_t i = 0;
  for (std::size_t k = 0; k < pieces + (closed ? 0 : 1); ++k) {
    const double at = along.back() * static_cast<double>(k) / static_cast<double>(pieces);
    while (i + 2 < along.size() && along[i + 1] < at) ++i;
    const double piece = along[i + 1] - along[i], f = piece > 0.0 ? (at - along[i]) / piece : 0.0;
    even.push_back((1.0 - f) * fine[i] + f * fine[i + 1]);
  }
  VOLTLAP_DEMAND(even.size() >= pieces);
  return even;
}

}  // namespace voltlap::plant
