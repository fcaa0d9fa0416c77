// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/arc_chain_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "race/track/import/banded_system.hpp"

namespace voltlap::plant {
namespace {

// What is known of a course before its points are: arcs of 3 to 20 m, radii from 4 m.
constexpr double kUsualLength_m = 8.0, kLengthSpread = 1.0;  // L_0, s_L
constexpr double kCurvatureSpread = 0.12;                    // s_kappa, 1/m
constexpr std::array<double, 5> kMisses = {0.1, 0.01, 1e-3, 1e-4, 1e-5};  // tau, m and rad
constexpr double kPassOn = 2e-3;  // tau below which a point beyond the end of its arc belongs to the next
constexpr double kLoosest = 10.0;  // tau at first, of the largest miss
constexpr double kMet = 1e-4;     // m and rad
constexpr double kHeld = 1e12;    // against which the points move nothing
constexpr int kRounds = 12, kHalvings = 4, kChases = 3;
constexpr double kLeast = 1e-6;  // that nothing is free
constexpr double kDone = 0.02;  // of the cost
constexpr double kMostMove_m = 0.5, kMostTurn_rad = 0.2, kMostBend = 0.1, kMostStretch = 0.5;  // in a step
constexpr std::size_t kAlong = 0, kLeft = 1, kHeading = 2, kBend = 3, kStretch = 4, kUnknowns = 5;  // of an arc

double square(double v) { return v * v; }

using Miss = std::array<double, 3>;  ///< along, to the left, heading
using Slopes = std::array<std::array<double, kUnknowns>, 3>;

class Fitting {
 public:
  Fitting(ArcChain& chain, const std::vector<WeightedPoint>& points, double noise_m)
      : chain_(chain), points_(points), per_square_(1.0 / square(noise_m)), begin_(chain.arcs.front().from) {}

  std::optional<ChainFit> run(double hopeless_above) {
    const double misses = largest_miss();
    for (const double tau : kMisses) {
      if (tau > kLoosest * misses && tau > kMisses.back()) continue;  // arcs that meet already stay as they are
      tau_ = tau;
      cost_ = cost();
      bool lowest = false;
      for (int round = 0; round < kRounds && !lowest; ++round) {
        if (tau_ < kPassOn && pass_points_on()) cost_ = cost();
        const double was = cost_;
        lowest = !improve() || was - cost_ < kDone;
      }
      if (lowest && cost_ > hopeless_above) return {};  // only rises from here
    }
    const double improbability = this->improbability();
    if (!std::isfinite(improbability)) return {};
    if (!chain_.ring && !chain_.end_held) chain_.end = end_of(chain_.arcs.back().arc, chain_.arcs.back().from);
    return ChainFit{cost_, improbability, largest_miss() < kMet};
  }

 private:
  [[nodiscard]] std::size_t size() const { return chain_.arcs.size(); }
  [[nodiscard]] std::size_t joints() const { return chain_.ring ? size() : size() - 1; }
  [[nodiscard]] std::size_t next(std::size_t k) const { return k + 1 < size() ? k + 1 : 0; }

  /// The first unknown of an arc: from both ends of the list in turn, so that a round course is a band, too.
  [[nodiscard]] std::size_t place_of(std::size_t k) const {
    return kUnknowns * (2 * k < size() ? 2 * k : 2 * (size() - 1 - k) + 1);
  }

  [[nodiscard]] static Miss miss(const PlanePose& is, const PlanePose& should) {
    const PlanePoint ahead = should.ahead(), off = is.at - should.at;
    return {dot(off, ahead), cross(ahead, off), std::remainder(is.heading_rad - should.heading_rad, 2.0 * M_PI)};
  }

  [[nodiscard]] Miss miss_at(std::size_t k) const {
    return miss(end_of(chain_.arcs[k].arc, chain_.arcs[k].from), chain_.arcs[next(k)].from);
  }

  [[nodiscard]] Miss start_miss() const { return miss(chain_.arcs.front().from, begin_); }
  [[nodiscard]] Miss end_miss() const {
    return miss(end_of(chain_.arcs.back().arc, chain_.arcs.back().from), chain_.end);
  }
  /// How many of place along, to the left and heading are kept at an end.
  [[nodiscard]] std::size_t kept_at_start() const { return chain_.ring ? 0 : chain_.start_held ? 3 : 1; }
  [[nodiscard]] std::size_t kept_at_end() const { return chain_.ring ? 0 : chain_.end_held ? 3 : 1; }

  [[nodiscard]] double largest_miss() const {
    double most = 0.0;
    for (std::size_t k = 0; k < joints(); ++k) {
      for (const double by : miss_at(k)) most = std::max(most, std::abs(by));
    }
    const Miss end = end_miss();
    for (std::size_t m = 0; m < kept_at_end(); ++m) most = std::max(most, std::abs(end[m]));
    return most;
  }

  [[nodiscard]] double cost() const {
    double sum = 0.0;
    for (const PlacedArc& placed : chain_.arcs) {
      const PlanePoint ahead = placed.from.ahead();
      for (const std::size_t i : placed.points) {
        const double offset_m = foot_of(points_[i].at, placed.arc, placed.from, ahead).offset_m;
        sum += points_[i].weight * per_square_ * square(offset_m);
      }
      sum += square(std::log(placed.arc.length_m / kUsualLength_m) / kLengthSpread);
      sum += square(placed.arc.curvature_per_m / kCurvatureSpread);
    }
    for (std::size_t k = 0; k < joints(); ++k) {
      for (const double by : miss_at(k)) sum += square(by / tau_);
    }
    for (std::size_t m = 0; m < kept_at_start(); ++m) sum += square(start_miss()[m] / tau_);
    for (std::size_t m = 0; m < kept_at_end(); ++m) sum += square(end_miss()[m] / tau_);
    return sum;
  }

  /// Whether any went over.
  bool pass_points_on() {
    bool any = false;
    for (std::size_t k = 0; k < size(); ++k) {
      PlacedArc& placed = chain_.arcs[k];
      const bool has_last = chain_.ring || k > 0, has_next = chain_.ring || k + 1 < size();
      const PlanePoint ahead = placed.from.ahead();
      std::vector<std::size_t> kept;
      for (const std::size_t i : placed.points) {
        const Foot foot = foot_of(points_[i].at, placed.arc, placed.from, ahead);
        if (has_next && foot.along_m > placed.arc.length_m) chain_.arcs[next(k)].points.push_back(i);
        else if (has_last && foot.along_m < 0.0) chain_.arcs[k > 0 ? k - 1 : size() - 1].points.push_back(i);
        else kept.push_back(i);
      }
      any = any || kept.size() < placed.points.size();
      placed.points = std::move(kept);
    }
    return any;
  }

  /// How what an arc's end misses the next start by depends on the arc.
  [[nodiscard]] Slopes end_slopes(std::size_t k, double next_heading_rad) const {
    const PlacedArc& placed = chain_.arcs[k];
    const EndSlopes end = end_slopes_of(placed.arc);
    const double c = std::cos(end.turn_rad), s = std::sin(end.turn_rad), length_m = placed.arc.length_m;
    const std::array<double, kUnknowns> ahead = {1.0, 0.0, -end.left_m, end.ahead_by_curvature, c * length_m};
    const std::array<double, kUnknowns> left = {0.0, 1.0, end.ahead_m, end.left_by_curvature, s * length_m};
    const double way = next_heading_rad - placed.from.heading_rad, cw = std::cos(way), sw = std::sin(way);
    Slopes slopes{};
    for (std::size_t p = 0; p < kUnknowns; ++p) {
      slopes[kAlong][p] = cw * ahead[p] + sw * left[p];
      slopes[kLeft][p] = cw * left[p] - sw * ahead[p];
    }
    slopes[kHeading] = {0.0, 0.0, 1.0, length_m, end.turn_rad};
    return slopes;
  }

  void add_points(BandedSystem& system, std::vector<double>& right, std::size_t k) const {
    const PlacedArc& placed = chain_.arcs[k];
    ArcEquations equations;
    const PlanePoint ahead = placed.from.ahead();
    for (const std::size_t i : placed.points) {
      const Foot foot = foot_of(points_[i].at, placed.arc, placed.from, ahead);
      equations.add(foot, points_[i].weight * per_square_);
    }
    const std::size_t at = place_of(k);
    for (std::size_t a = 0; a < 4; ++a) {
      right[at + a] += equations.right[a];
      for (std::size_t b = 0; b <= a; ++b) system.add(at + a, at + b, equations.square[a][b]);
    }
    const double stretch = 1.0 / square(kLengthSpread), bend = 1.0 / square(kCurvatureSpread);
    system.add(at + kStretch, at + kStretch, stretch);
    right[at + kStretch] -= stretch * std::log(placed.arc.length_m / kUsualLength_m);
    system.add(at + kBend, at + kBend, placed.arc.straight ? kHeld : bend);
    if (placed.arc.straight) right[at + kBend] = 0.0;
    else right[at + kBend] -= bend * placed.arc.curvature_per_m;
  }

  void add_joint(BandedSystem& system, std::vector<double>& right, std::size_t k) const {
    const Miss by = miss_at(k);
    const Slopes slopes = end_slopes(k, chain_.arcs[next(k)].from.heading_rad);
    const double weight = 1.0 / square(tau_);
    const std::size_t here = place_of(k), there = place_of(next(k));
    for (std::size_t m = 0; m < 3; ++m) {
      const auto slope = [&](std::size_t p) {
        return chain_.arcs[k].arc.straight && p == kBend ? 0.0 : slopes[m][p];
      };
      for (std::size_t p = 0; p < kUnknowns; ++p) {
        right[here + p] -= weight * by[m] * slope(p);
        system.add(there + m, here + p, -weight * slope(p));
        for (std::size_t q = 0; q <= p; ++q) system.add(here + p, here + q, weight * slope(p) * slope(q));
      }
      right[there + m] += weight * by[m];
      system.add(there + m, there + m, weight);
    }
  }

  void add_ends(BandedSystem& system, std::vector<double>& right) const {
    const double weight = 1.0 / square(tau_);
    const std::size_t first = place_of(0), last = place_of(size() - 1);
    const Miss start = start_miss(), end = end_miss();
    for (std::size_t m = 0; m < kept_at_start(); ++m) {
      system.add(first + m, first + m, weight);
      right[first + m] -= weight * start[m];
    }
    const Slopes slopes = end_slopes(size() - 1, chain_.end.heading_rad);
    for (std::size_t m = 0; m < kept_at_end(); ++m) {
      for (std::size_t p = 0; p < kUnknowns; ++p) {
        right[last + p] -= weight * end[m] * slopes[m][p];
        for (std::size_t q = 0; q <= p; ++q) system.add(last + p, last + q, weight * slopes[m][p] * slopes[m][q]);
      }
    }
  }

  /// The normal equations about the arcs as they are; false when they are singular.
  bool factorise(BandedSystem& system, std::vector<double>& right) const {
    for (std::size_t k = 0; k < size(); ++k) add_points(system, right, k);
    for (std::size_t k = 0; k < joints(); ++k) add_joint(system, right, k);
    add_ends(system, right);
    for (std::size_t p = 0; p < right.size(); ++p) system.add(p, p, kLeast);
    for (std::size_t k = 0; k < size(); ++k) {
      if (chain_.arcs[k].arc.straight) right[place_of(k) + kBend] = 0.0;
    }
    return system.factorise();
  }
  [[nodiscard]] BandedSystem empty_system() const {
    return {kUnknowns * size(), std::min(kUnknowns * size() - 1, 3 * kUnknowns - 1)};
  }

  [[nodiscard]] double improbability() const {
    BandedSystem system = empty_system();
    std::vector<double> right(system.size(), 0.0);
    if (!factorise(system, right)) return std::numeric_limits<double>::infinity();
    double sum = cost_ + system.log_determinant() + 3.0 * static_cast<double>(joints()) * std::log(square(tau_));
    for (const PlacedArc& placed : chain_.arcs) {
      sum += std::log(square(kLengthSpread)) + 2.0 * std::log(2.0);
      sum += placed.arc.straight ? -std::log(kHeld) : std::log(square(kCurvatureSpread));
    }
    return sum;
  }

  /// Some steps of Gauss and Newton, the first shortened until they are an improvement together: where an end slides
  /// along a bend, the second undoes the miss that the first leaves. False, and as it was, where none are.
  bool improve() {
    const std::vector<PlacedArc> before = chain_.arcs;
    double share = 1.0;
    for (int half = 0; half < kHalvings; ++half, share *= 0.3) {
      for (int chase = 0; chase < kChases; ++chase) {
        if (!step(chase == 0 ? share : 1.0)) break;
        const double is = cost();
        if (!(is < cost_)) continue;
        cost_ = is;
        return true;
      }
      chain_.arcs = before;
    }
    return false;
  }

  /// False where the equations are singular.
  bool step(double share) {
    BandedSystem system = empty_system();
    std::vector<double> right(system.size(), 0.0);
    if (!factorise(system, right)) return false;
    const std::vector<double> moves = system.solved(right);
    share = std::min(share, longest_share(moves));
    for (std::size_t k = 0; k < size(); ++k) move(chain_.arcs[k], &moves[place_of(k)], share);
    return true;
  }

  [[nodiscard]] double longest_share(const std::vector<double>& step) const {
    constexpr std::array<double, kUnknowns> kMost = {kMostMove_m, kMostMove_m, kMostTurn_rad, kMostBend, kMostStretch};
    double most = 1.0;
    for (std::size_t p = 0; p < step.size(); ++p) most = std::max(most, std::abs(step[p]) / kMost[p % kUnknowns]);
    return 1.0 / most;
  }

  static void move(PlacedArc& placed, const double* step, double share) {
    const PlanePoint ahead = placed.from.ahead();
    placed.from.at = placed.from.at + share * step[kAlong] * ahead + share * step[kLeft] * left_of(ahead);
    placed.from.heading_rad += share * step[kHeading];
    if (!placed.arc.straight) placed.arc.curvature_per_m += share * step[kBend];
    placed.arc.length_m *= std::exp(share * step[kStretch]);
  }

  ArcChain& chain_;
  const std::vector<WeightedPoint>& points_;
  double per_square_;
  PlanePose begin_;
  double tau_ = kMisses.front(), cost_ = 0.0;
};

}  // namespace

std::optional<ChainFit> fit_chain(ArcChain& chain, const std::vector<WeightedPoint>& points, double noise_m,
                                  double hopeless_above) {
  VOLTLAP_DEMAND(!chain.arcs.empty() && noise_m > 0.0);
  return Fitting(chain, points, noise_m).run(hopeless_above);
}

}  // namespace voltlap::plant
