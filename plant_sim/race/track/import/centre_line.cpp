// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/centre_line.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "race/track/import/exact_arcs.hpp"
#include "race/track/import/golden_section.hpp"
#include "race/track/import/node_chain.hpp"
#include "race/track/import/node_moves.hpp"

namespace voltlap::plant {
namespace {

constexpr int kEvenRounds = 8;
constexpr int kOwnRounds = 30;
constexpr int kArcRounds = 100;
constexpr int kPlaceRounds = 6;
constexpr double kLeastNoise_m = 1e-3;
constexpr double kNoChange2 = 1e-12;    // 1/m^2: the variance of a change where there is none
constexpr double kAnyChange2 = 0.05;    // of one that may be as large as it likes: a corner of 4 m next to a straight
constexpr double kSupport = 25.0;       // change^2 / variance that a change needs, about 2 ln(points)
constexpr double kShortestArc_m = 1.5;
constexpr double kExact_m = 0.02;        // noise below which points are followed as they are
constexpr double kForArcs = 0.1;         // information per point by which arcs are believed in beforehand
constexpr double kSameCurvature = 1e-3;  // 1/m, within which nodes of the even line are one arc
constexpr double kSameTurn_rad = 0.3;
constexpr double kSameLength = 0.02;     // of arcs through exact points with the even line
constexpr double kRounding_m = 1e-4;     // of the points' coordinates, below which no line is better than another
// Of an even change against a point. Less lets exact points ring where a corner begins, as Gibbs has it; more widens
// hairpins.
constexpr double kLeastWeight_log10 = -1.8;
constexpr double kLeastChange = 1e-5;   // of the largest, below which a change is none
constexpr double kNoFit = 1e300;
constexpr double kMostWeight = 1e8;     // of a change against a point: what double precision carries

double square(double v) { return v * v; }

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
    const CentreLine even = result();
    const double even_noise_m = noise_m_, even_cost = information_of_even();
    if (!options_.arcs) return even;
    if (even_noise_m < kExact_m) return exact(even);
    for (int round = 0; round < kOwnRounds; ++round) own_round();
    report(0.6);
    find_arcs();
    const double points = static_cast<double>(chain_.offsets().size());
    const double arcs_cost = information(squares_, 2.0 * static_cast<double>(places_.size()));
    const CentreLine arcs = result();
    return same_turn(arcs, even) && arcs_cost < even_cost + kForArcs * points ? arcs : even;
  }

 private:
  [[nodiscard]] bool noise_is_measured() const { return options_.noise_m < 0.0; }
  void report(double share) const {
    if (options_.progress) options_.progress(share);
  }

  /// What is minimised, where the nodes are: squares of the points against 1 and of the changes against `weights`.
  [[nodiscard]] static double cost(const NodeChain& chain, const std::vector<double>& weights) {
    double sum = 0.0;
    for (const PointOffset& offset : chain.offsets()) sum += offset.weight * square(offset.value);
    for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * square(chain.changes()[k].value);
    return sum;
  }

  /// Moves the nodes by what `moves` found, damped until it is an improvement (Levenberg, 1944); stays where none is.
  void step(NodeMoves& moves, const std::vector<double>& weights) {
    const double before = cost(chain_, weights);
    for (const double damping : {0.0, 1e-2, 1.0, 1e2, 1e4}) {
      if (damping > 0.0) moves.solve(weights, damping);
      NodeChain moved = chain_;
      moved.move(moves.moves());
      moved.linearise();
      if (cost(moved, weights) > before) continue;
      chain_ = std::move(moved);
      return;
    }
  }

  [[nodiscard]] static double turned(const CentreLine& line) {
    double sum = 0.0;
    for (const Arc& arc : line.arcs) sum += arc.length_m * arc.curvature_per_m;
    return sum;
  }
  [[nodiscard]] static bool same_turn(const CentreLine& line, const CentreLine& even) {
    return std::abs(turned(line) - turned(even)) < kSameTurn_rad;
  }

  [[nodiscard]] static double way(const CentreLine& line) {
    double sum = 0.0;
    for (const Arc& arc : line.arcs) sum += arc.length_m;
    return sum;
  }

  /// Arcs through points without noise about the even line, or that line where they do not make the course.
  [[nodiscard]] CentreLine exact(const CentreLine& even) const {
    const ArcSearchOptions how{noise_is_measured(), [this](double share) { report(0.4 + 0.6 * share); }};
    const ArcCourse found = find_exact_arcs(chain_, noise_m_, how);
    CentreLine line{{}, chain_.nodes(), found.noise_m, chain_.offsets().size()};
    for (const PlacedArc& arc : found.arcs) line.arcs.push_back(arc.arc);
    line.of_segments = true;
    const bool same_length = std::abs(way(line) / way(even) - 1.0) < kSameLength;
    const bool same_course = found.meets && same_turn(line, even) && same_length;
    double figures = 0.0;
    for (const Arc& arc : line.arcs) figures += arc.straight ? 1.0 : 2.0;
    const double arcs_cost = information(found.squares, figures, kRounding_m);
    return same_course && arcs_cost < information(squares_, figures_, kRounding_m) ? line : even;
  }

  // 1 even ------------------------------------------------------------------------------------------------------------
  /// -2 log of the restricted likelihood at lambda = sigma^2 / q^2; sets the noise.
  double misfit(NodeMoves& moves, double log10_lambda) {
    const double lambda = std::pow(10.0, log10_lambda);
    if (!moves.try_solve(std::vector<double>(chain_.changes().size(), lambda))) return kNoFit;
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
    NodeMoves moves(chain_);
    const double lambda = golden_section(kLeastWeight_log10, std::log10(kMostWeight), 0.1,
                                         [&](double at) { return misfit(moves, at); });
    misfit(moves, lambda);
    step(moves, std::vector<double>(chain_.changes().size(), std::pow(10.0, lambda)));
    change2_.assign(chain_.changes().size(), square(noise_m_) / std::pow(10.0, lambda));
  }

  /// Bayesian information (Schwarz, 1978) of points that lie about a line with so many free figures.
  [[nodiscard]] double information(double squares, double figures, double least_noise_m = kLeastNoise_m) const {
    const double points = static_cast<double>(chain_.offsets().size());
    const double per_point = std::max(square(least_noise_m), squares / points);
    const double misfit = noise_is_measured() ? points * std::log(per_point) : squares / square(noise_m_);
    return misfit + figures * std::log(points);
  }

  /// Free figures of the even line: the trace of what turns points into the line.
  double information_of_even() {
    chain_.linearise();
    NodeMoves moves(chain_);
    moves.solve(weights());
    moves.find_variances();
    double figures = 0.0;
    for (const PointOffset& offset : chain_.offsets()) figures += offset.weight * moves.variance(offset);
    figures_ = figures;
    squares_ = moves.squares_left();
    return information(squares_, figures);
  }

  // 2 own -------------------------------------------------------------------------------------------------------------
  [[nodiscard]] std::vector<double> weights() const {
    std::vector<double> weights;
    for (const double change2 : change2_) weights.push_back(std::min(kMostWeight, square(noise_m_) / change2));
    return weights;
  }

  void own_round() {
    chain_.linearise();
    NodeMoves moves(chain_);
    const std::vector<double> weights_now = weights();
    moves.solve(weights_now);
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
    step(moves, weights_now);
  }

  void set_noise(double squares, double freedom) {
    if (noise_is_measured()) noise_m_ = std::max(kLeastNoise_m, std::sqrt(squares / std::max(1.0, freedom)));
  }

  // 3 arcs ------------------------------------------------------------------------------------------------------------
  // About the line of stage 2 as it is: what is sought is a linear function of the moves, and none is made.
  [[nodiscard]] std::size_t neighbour(std::size_t k, long offset) const {
    const auto n = static_cast<long>(change2_.size()), at = static_cast<long>(k) + offset;
    if (chain_.closed()) return static_cast<std::size_t>((at + n) % n);
    return static_cast<std::size_t>(std::clamp(at, 0L, n - 1));
  }
  [[nodiscard]] double change(std::size_t k) const { return chain_.changes()[k].at(moves_); }
  /// At a place and on both sides of it.
  [[nodiscard]] double whole_change(std::size_t k) const {
    return change(neighbour(k, -1)) + change(k) + change(neighbour(k, 1));
  }

  /// A place wherever a change is larger than its neighbours.
  void choose_places() {
    chain_.linearise();
    moves_.assign(chain_.size(), 0.0);
    places_.clear();
    double largest = 0.0;
    for (std::size_t k = 0; k < change2_.size(); ++k) largest = std::max(largest, std::abs(change(k)));
    for (std::size_t k = 0; k < change2_.size(); ++k) {
      const double here = std::abs(change(k)), before = std::abs(change(neighbour(k, -1)));
      const bool peak = here >= before && here > std::abs(change(neighbour(k, 1)));
      if (peak && here > kLeastChange * largest) places_.push_back(k);
    }
  }

  /// Changes at the places alone, beside them as much as moves a place by one node.
  void allow_changes(bool places_move) {
    change2_.assign(chain_.changes().size(), kNoChange2);
    for (const std::size_t k : places_) {
      if (!places_move) break;
      for (const long side : {-1L, 1L}) {
        double& beside = change2_[neighbour(k, side)];
        beside = std::max(beside, square(whole_change(k)));
      }
    }
    for (const std::size_t k : places_) change2_[k] = kAnyChange2;
  }

  void solve_arcs(bool places_move) {
    allow_changes(places_move);
    NodeMoves moves(chain_);
    moves.solve(weights());
    moves.find_variances();
    moves_ = moves.moves();
    const double points = static_cast<double>(chain_.offsets().size());
    squares_ = moves.squares_left();
    set_noise(squares_, points - 2.0 * static_cast<double>(places_.size()));
    support_.clear();
    for (const std::size_t k : places_) {
      const double variance = square(noise_m_) * std::max(1e-300, moves.variance(chain_.changes()[k]));
      support_.push_back(square(change(k)) / variance);
    }
  }

  /// A change that wants to be more before a place than behind it moves the place.
  void move_places() {
    solve_arcs(true);
    std::vector<std::size_t> moved;
    for (const std::size_t k : places_) {
      const double whole = whole_change(k), difference = change(neighbour(k, 1)) - change(neighbour(k, -1));
      const double by = whole == 0.0 ? 0.0 : std::clamp(difference / whole, -2.0, 2.0);
      moved.push_back(neighbour(k, std::lround(by)));
    }
    std::sort(moved.begin(), moved.end());
    places_.clear();
    for (const std::size_t k : moved) {
      if (places_.empty() || step_m_ * static_cast<double>(k - places_.back()) >= kShortestArc_m) places_.push_back(k);
    }
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
      solve_arcs(false);
      if (take_out_places()) {
        move_places();
        continue;
      }
      for (int k = 0; k < kPlaceRounds; ++k) move_places();
      solve_arcs(false);
      if (!take_out_places()) break;
      report(0.6 + 0.4 * round / kArcRounds);
    }
    solve_arcs(false);
  }

  /// An arc from place to place; before stage 3 one from where the curvature has changed to where it has again.
  CentreLine result() {
    if (moves_.empty()) chain_.linearise();
    const bool even = moves_.empty();
    const std::vector<double> moves = even ? std::vector<double>(chain_.size(), 0.0) : moves_;
    CentreLine line{{}, chain_.nodes(), noise_m_, chain_.offsets().size()};
    const std::vector<double> between = chain_.arc_lengths();
    const std::size_t n = chain_.size();
    std::vector<bool> ends(n, false);  // an arc ends behind the node
    for (const std::size_t k : places_) ends[(k + chain_.first_change()) % n] = true;
    std::vector<double> curvature;
    for (const NodeCurvature& at : chain_.curvatures()) curvature.push_back(at.at(moves));
    if (!chain_.closed()) {
      curvature.front() = curvature[1];
      curvature.back() = curvature[n - 2];
    }
    Arc arc{0.0, 0.0};
    std::size_t first = 0;  // node of the arc
    const auto finish = [&] {
      if (arc.length_m > 0.0) line.arcs.push_back({arc.length_m, arc.curvature_per_m / arc.length_m});
      arc = {0.0, 0.0};
    };
    for (std::size_t j = 0; j < n; ++j) {
      const bool open_start = !chain_.closed() && j == 0, open_end = !chain_.closed() && j + 1 == n;
      const double cell = 0.5 * ((open_start ? 0.0 : between[chain_.before(j)]) + (open_end ? 0.0 : between[j]));
      arc.length_m += cell;
      arc.curvature_per_m += cell * curvature[j];
      const double more = std::abs(curvature[chain_.next(j)] - curvature[first]);
      if (even ? more > kSameCurvature : ends[j]) {
        finish();
        first = j + 1;
      }
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
  std::vector<double> support_;       ///< of the places: change^2 / variance
  std::vector<double> moves_;         ///< from the nodes to the line, in stage 3
  double figures_ = 0.0;              ///< free ones of the even line
  double squares_ = 0.0;              ///< left between points and line
};

}  // namespace

CentreLine fit_centre_line(const PointList& start, const PointList& points, const CentreLineOptions& options) {
  VOLTLAP_DEMAND(start.size() >= 8 && points.size() >= 3);
  return CentreLineFit(start, points, options).run();
}

}  // namespace voltlap::plant
