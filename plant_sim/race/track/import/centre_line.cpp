// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/centre_line.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "race/track/import/banded_system.hpp"
#include "race/track/import/golden_section.hpp"
#include "race/track/import/node_chain.hpp"

namespace voltlap::plant {
namespace {

constexpr int kEvenRounds = 6;
constexpr int kOwnRounds = 30;
constexpr int kArcRounds = 100;
constexpr int kPlaceRounds = 6;
constexpr double kLeastNoise_m = 1e-3;
constexpr double kNoChange2 = 1e-12;    // 1/m^2: the variance of a change where there is none
constexpr double kAnyChange2 = 0.05;    // of one that may be as large as it likes: a corner of 4 m next to a straight
constexpr double kSupport = 20.0;       // change^2 / variance that a change needs, about 2 ln(points)
constexpr double kRidge = 1e-9;
constexpr double kMostWeight = 1e9;     // of a change against a point: what double precision carries

double square(double v) { return v * v; }

/// The weighted least squares of one round: unknown are the moves of the nodes.
class Moves {
 public:
  explicit Moves(const NodeChain& chain)
      : chain_(chain), system_(chain.size(), chain.closed() ? 6 : 3), right_(chain.size(), 0.0) {}

  /// `weights` of the curvature changes against the points' 1; solves.
  void solve(const std::vector<double>& weights) {
    system_.clear();
    std::fill(right_.begin(), right_.end(), 0.0);
    for (const PointOffset& offset : chain_.offsets()) add(offset, offset.weight);
    for (std::size_t k = 0; k < weights.size(); ++k) add(chain_.changes()[k], weights[k]);
    for (std::size_t j = 0; j < chain_.size(); ++j) system_.add(j, j, kRidge);
    VOLTLAP_DEMAND(system_.factorise());
    const std::vector<double> by_row = system_.solved(right_);
    moves_.resize(by_row.size());
    for (std::size_t j = 0; j < moves_.size(); ++j) moves_[j] = by_row[row(j)];
  }
  [[nodiscard]] const std::vector<double>& moves() const { return moves_; }
  [[nodiscard]] double log_determinant() const { return system_.log_determinant(); }

  /// Makes `variance` available.
  void find_variances() { system_.invert_band(); }
  /// Of a function of the moves, for points of noise 1.
  template <std::size_t N>
  [[nodiscard]] double variance(const NodeFunction<N>& f) const {
    double sum = 0.0;
    for (std::size_t a = 0; a < N; ++a) {
      for (std::size_t b = 0; b < N; ++b) {
        sum += f.slope[a] * f.slope[b] * system_.inverse(row(f.node[a]), row(f.node[b]));
      }
    }
    return sum;
  }
  /// Sum of squares of what is left between points and line.
  [[nodiscard]] double squares_left() const {
    double sum = 0.0;
    for (const PointOffset& offset : chain_.offsets()) sum += offset.weight * square(offset.at(moves_));
    return sum;
  }

 private:
  /// A closed chain is folded flat, 0, n - 1, 1, n - 2 ..., so that neighbours stay within the band.
  [[nodiscard]] std::size_t row(std::size_t node) const {
    const std::size_t n = chain_.size();
    if (!chain_.closed()) return node;
    return node < (n + 1) / 2 ? 2 * node : 2 * (n - 1 - node) + 1;
  }
  template <std::size_t N>
  void add(const NodeFunction<N>& f, double weight) {
    for (std::size_t a = 0; a < N; ++a) {
      right_[row(f.node[a])] -= weight * f.slope[a] * f.value;
      for (std::size_t b = 0; b <= a; ++b) {
        system_.add(row(f.node[a]), row(f.node[b]), weight * f.slope[a] * f.slope[b]);
      }
    }
  }

  const NodeChain& chain_;
  BandedSystem system_;
  std::vector<double> right_, moves_;
};

class CentreLineFit {
 public:
  CentreLineFit(const PointList& start, const PointList& points, const CentreLineOptions& options)
      : options_(options), step_m_(length(start[1] - start[0])), chain_(start, points, options.closed) {
    if (options.noise_m >= 0.0) noise_m_ = std::max(kLeastNoise_m, options.noise_m);
  }

  CentreLine run() {
    for (int round = 0; round < kEvenRounds; ++round) {
      if (round > 0) chain_.respace(step_m_);
      even_round();
      report(0.4 * (round + 1) / kEvenRounds);
    }
    for (int round = 0; round < kOwnRounds; ++round) own_round();
    report(0.6);
    find_arcs();
    return result();
  }

 private:
  [[nodiscard]] bool noise_is_measured() const { return options_.noise_m < 0.0; }
  void report(double share) const {
    if (options_.progress) options_.progress(share);
  }

  // 1 even ------------------------------------------------------------------------------------------------------------
  /// -2 log of the restricted likelihood at lambda = sigma^2 / q^2; sets the noise.
  double misfit(Moves& moves, double log10_lambda) {
    const double lambda = std::pow(10.0, log10_lambda);
    moves.solve(std::vector<double>(chain_.changes().size(), lambda));
    double squares = moves.squares_left();
    for (const CurvatureChange& change : chain_.changes()) squares += lambda * square(change.at(moves.moves()));
    const double points = std::max(1.0, static_cast<double>(chain_.offsets().size()) - 3.0);
    const double changes = static_cast<double>(chain_.changes().size()) - 3.0;
    const double rest = moves.log_determinant() - changes * std::log(lambda);
    if (!noise_is_measured()) return squares / square(noise_m_) + rest;
    noise_m_ = std::max(kLeastNoise_m, std::sqrt(squares / points));
    return points * std::log(squares / points + 1e-12) + rest;
  }

  void even_round() {
    chain_.linearise();
    Moves moves(chain_);
    const double lambda = golden_section(-4.0, std::log10(kMostWeight), 0.1, [&](double at) { return misfit(moves, at); });
    misfit(moves, lambda);
    chain_.move(moves.moves());
    change2_.assign(chain_.changes().size(), square(noise_m_) / std::pow(10.0, lambda));
  }

  // 2 own -------------------------------------------------------------------------------------------------------------
  [[nodiscard]] std::vector<double> weights() const {
    std::vector<double> weights;
    for (const double change2 : change2_) weights.push_back(std::min(kMostWeight, square(noise_m_) / change2));
    return weights;
  }

  void own_round() {
    chain_.linearise();
    Moves moves(chain_);
    moves.solve(weights());
    moves.find_variances();
    double squares = moves.squares_left();
    for (const PointOffset& offset : chain_.offsets()) {
      squares += offset.weight * square(noise_m_) * moves.variance(offset);
    }
    for (std::size_t k = 0; k < change2_.size(); ++k) {
      const CurvatureChange& change = chain_.changes()[k];
      const double expected = square(change.at(moves.moves())) + square(noise_m_) * moves.variance(change);
      change2_[k] = std::max(1e-2 * kNoChange2, expected);
    }
    set_noise(squares, static_cast<double>(chain_.offsets().size()));
    chain_.move(moves.moves());
  }

  void set_noise(double squares, double freedom) {
    if (noise_is_measured()) noise_m_ = std::max(kLeastNoise_m, std::sqrt(squares / std::max(1.0, freedom)));
  }

  // 3 arcs ------------------------------------------------------------------------------------------------------------
  [[nodiscard]] std::size_t neighbour(std::size_t k, long offset) const {
    const auto n = static_cast<long>(change2_.size()), at = static_cast<long>(k) + offset;
    if (chain_.closed()) return static_cast<std::size_t>((at + n) % n);
    return static_cast<std::size_t>(std::clamp(at, 0L, n - 1));
  }

  /// A place wherever a change is larger than its neighbours.
  void choose_places() {
    chain_.linearise();
    places_.clear();
    const auto size = [&](std::size_t k) { return std::abs(chain_.changes()[k].value); };
    double largest = 0.0;
    for (std::size_t k = 0; k < change2_.size(); ++k) largest = std::max(largest, size(k));
    for (std::size_t k = 0; k < change2_.size(); ++k) {
      const double here = size(k);
      const bool peak = here >= size(neighbour(k, -1)) && here > size(neighbour(k, 1));
      if (peak && here > 1e-5 * largest) places_.push_back(k);
    }
  }

  /// Changes at the places alone, beside them as much as moves a place by one node.
  void allow_changes(bool places_move) {
    change2_.assign(chain_.changes().size(), kNoChange2);
    for (const std::size_t k : places_) {
      if (!places_move) continue;
      const std::size_t a = neighbour(k, -1), b = neighbour(k, 1);
      const double whole = chain_.changes()[a].value + chain_.changes()[k].value + chain_.changes()[b].value;
      for (const std::size_t beside : {a, b}) change2_[beside] = std::max(change2_[beside], square(whole));
    }
    for (const std::size_t k : places_) change2_[k] = kAnyChange2;
  }

  void arcs_round(bool places_move) {
    chain_.linearise();
    allow_changes(places_move);
    Moves moves(chain_);
    moves.solve(weights());
    moves.find_variances();
    const double points = static_cast<double>(chain_.offsets().size());
    set_noise(moves.squares_left(), points - 2.0 * static_cast<double>(places_.size()));
    support_.clear();
    std::vector<std::size_t> moved;
    for (const std::size_t k : places_) {
      const CurvatureChange& change = chain_.changes()[k];
      const auto size = [&](std::size_t at) { return chain_.changes()[at].at(moves.moves()); };
      support_.push_back(square(size(k)) / (square(noise_m_) * std::max(1e-300, moves.variance(change))));
      const double whole = size(neighbour(k, -1)) + size(k) + size(neighbour(k, 1));
      const double by = whole == 0.0 ? 0.0 : (size(neighbour(k, 1)) - size(neighbour(k, -1))) / whole;
      moved.push_back(neighbour(k, std::lround(std::clamp(by, -2.0, 2.0))));
    }
    if (places_move) {
      std::sort(moved.begin(), moved.end());
      moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
      places_ = std::move(moved);
    }
    chain_.move(moves.moves());
  }

  /// Takes out the least supported places, no two neighbours at once; false when all are supported.
  bool take_out_places() {
    VOLTLAP_DEMAND(support_.size() == places_.size());
    const std::size_t n = places_.size();
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < n; ++k) {
      const bool least = support_[k] <= support_[(k + n - 1) % n] && (n == 1 || support_[k] < support_[(k + 1) % n]);
      if (!(least && support_[k] < kSupport)) kept.push_back(places_[k]);
    }
    const bool any = kept.size() < n;
    places_ = std::move(kept);
    return any;
  }

  void find_arcs() {
    choose_places();
    for (int round = 0; round < kArcRounds; ++round) {
      arcs_round(false);
      if (take_out_places()) {
        arcs_round(true);
        continue;
      }
      for (int k = 0; k < kPlaceRounds; ++k) arcs_round(true);
      arcs_round(false);
      if (!take_out_places()) break;
      report(0.6 + 0.4 * round / kArcRounds);
    }
    for (int k = 0; k < 3; ++k) arcs_round(false);
  }

  CentreLine result() {
    chain_.linearise();
    CentreLine line{{}, chain_.nodes(), noise_m_, chain_.offsets().size()};
    const std::vector<double> between = chain_.arc_lengths();
    const std::size_t n = chain_.size();
    std::vector<bool> ends(n, false);  // an arc ends behind the node
    for (const std::size_t k : places_) ends[(k + chain_.first_change()) % n] = true;
    Arc arc{0.0, 0.0};
    const auto finish = [&] {
      if (arc.length_m > 0.0) line.arcs.push_back({arc.length_m, arc.curvature_per_m / arc.length_m});
      arc = {0.0, 0.0};
    };
    for (std::size_t j = 0; j < n; ++j) {
      const bool open_start = !chain_.closed() && j == 0, open_end = !chain_.closed() && j + 1 == n;
      const double cell = 0.5 * ((open_start ? 0.0 : between[chain_.before(j)]) + (open_end ? 0.0 : between[j]));
      arc.length_m += cell;
      arc.curvature_per_m += cell * chain_.curvatures()[j].value;
      if (ends[j]) finish();
    }
    finish();
    VOLTLAP_DEMAND(!line.arcs.empty());
    return line;
  }

  const CentreLineOptions& options_;
  double step_m_;
  NodeChain chain_;
  double noise_m_ = kLeastNoise_m;
  std::vector<double> change2_;       ///< q_j^2
  std::vector<std::size_t> places_;   ///< indices of the changes that are there
  std::vector<double> support_;       ///< of the places
};

}  // namespace

CentreLine fit_centre_line(const PointList& start, const PointList& points, const CentreLineOptions& options) {
  VOLTLAP_DEMAND(start.size() >= 8 && points.size() >= 3);
  return CentreLineFit(start, points, options).run();
}

}  // namespace voltlap::plant
