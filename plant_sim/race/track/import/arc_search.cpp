// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/arc_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/demand.hpp"
#include "race/track/import/arc_chain_fit.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMargin = 2;         // arcs fitted anew on both sides of a change
constexpr std::size_t kMostJoined = 5;     // arcs that become one at once
constexpr std::size_t kFewestArcs = 4;
constexpr int kRounds = 4, kSweeps = 3;
constexpr double kLeastGain = 0.1;         // of -2 ln p
constexpr double kHopeless = 60.0;         // of the cost, which no smaller number of arcs makes up for
constexpr double kLeastNoise_m = 1e-3;
constexpr double kSameNoise = 0.01;
constexpr double kShortestPiece_m = 0.01;

double square(double v) { return v * v; }

/// `used` arcs from `at` on give way to `by`.
struct Move {
  std::size_t at, used;
  std::vector<Arc> by;
};

struct Range {
  std::size_t first, count;
  bool operator==(const Range&) const = default;
};

struct Outcome {
  double gain = 0.0;
  Range range{};
  ArcChain chain;
};

class ArcSearch {
 public:
  ArcSearch(ArcCourse course, const std::vector<WeightedPoint>& points, const ArcSearchOptions& options)
      : course_(std::move(course)), points_(points), options_(options),
        merge_gain_(course_.arcs.size()), settled_(course_.arcs.size(), false) {}

  ArcCourse run() {
    refit();
    measure_noise();
    ArcCourse best = course_;
    for (int round = 0; round < kRounds; ++round) {
      for (int sweep = 0; sweep < kSweeps; ++sweep) {
        share_done_ = (round + (sweep + 1.0) / (kSweeps + 1)) / kRounds;
        if (!try_moves_everywhere()) break;
        merge_neighbours();
      }
      refit();
      const bool changed = measure_noise();
      if (information(course_, points_.size()) < information(best, points_.size())) best = course_;
      if (!changed) break;
    }
    course_ = std::move(best);
    if (course_.closed) begin_at_start();
    return std::move(course_);
  }

 private:
  [[nodiscard]] std::size_t size() const { return course_.arcs.size(); }
  [[nodiscard]] const PlacedArc& placed(std::size_t k) const { return course_.arcs[k % size()]; }

  // windows -----------------------------------------------------------------------------------------------------------
  /// `used` arcs from k on with the margin on both sides; none where there are not so many.
  [[nodiscard]] std::optional<Range> around(std::size_t k, std::size_t used) const {
    const std::size_t n = size();
    if (course_.closed) {
      if (used + 1 > n) return {};
      const std::size_t count = std::min(n, used + 2 * kMargin);
      return Range{(k + n - (count - used) / 2) % n, count};
    }
    if (k + used > n) return {};
    const std::size_t first = k > kMargin ? k - kMargin : 0;
    return Range{first, std::min(n, k + used + kMargin) - first};
  }

  [[nodiscard]] ArcChain chain(const Range& range) const {
    const std::size_t behind = range.first + range.count;
    const bool ends_course = !course_.closed && behind == size();
    ArcChain chain{{}, ends_course ? course_.end : placed(behind).from};
    chain.start_held = course_.closed || range.first > 0;
    chain.end_held = !ends_course;
    for (std::size_t j = 0; j < range.count; ++j) chain.arcs.push_back(placed(range.first + j));
    return chain;
  }

  /// The range becomes the chain; a range across the end of the list is brought together first.
  void put(Range range, const ArcChain& chain) {
    const std::size_t n = size();
    forget_about(range);
    if (range.first + range.count > n) {
      const auto wrapped = static_cast<long>(range.first + range.count - n);
      std::rotate(course_.arcs.begin(), course_.arcs.begin() + wrapped, course_.arcs.end());
      std::rotate(merge_gain_.begin(), merge_gain_.begin() + wrapped, merge_gain_.end());
      std::rotate(settled_.begin(), settled_.begin() + wrapped, settled_.end());
      range.first -= static_cast<std::size_t>(wrapped);
    }
    if (!course_.closed && !chain.end_held) course_.end = chain.end;
    const auto replace = [&](auto& list, const auto& by) {
      const auto at = list.begin() + static_cast<long>(range.first);
      list.insert(list.erase(at, at + static_cast<long>(range.count)), by.begin(), by.end());
    };
    replace(course_.arcs, chain.arcs);
    replace(merge_gain_, std::vector<std::optional<double>>(chain.arcs.size()));
    replace(settled_, std::vector<bool>(chain.arcs.size(), false));
    VOLTLAP_DEMAND(merge_gain_.size() == size() && settled_.size() == size());
  }

  /// What was known of places whose windows reach into the range.
  void forget_about(const Range& range) {
    const std::size_t n = size(), reach = std::min(n, 2 * kMargin + 1);
    for (std::size_t j = 0; j < range.count + 2 * reach; ++j) {
      const std::size_t at = (range.first + n - reach + j) % n;
      merge_gain_[at].reset();
      settled_[at] = false;
    }
    fitted_range_ = {};
  }

  /// The range as it is, fitted; kept for the next move at the same place.
  const std::optional<ChainFit>& fitted(const Range& range) {
    if (fitted_range_ != range) {
      fitted_ = chain(range);
      fitted_range_ = range;
      fit_ = fit_chain(fitted_, points_, course_.noise_m);
    }
    return fit_;
  }

  // moves -------------------------------------------------------------------------------------------------------------
  /// How much more probable the course is after a move; none where it cannot be made.
  std::optional<Outcome> outcome_of(const Move& move) {
    const std::optional<Range> range = around(move.at, move.used);
    if (!range) return {};
    const std::optional<ChainFit>& before = fitted(*range);
    if (!before) return {};
    const std::size_t at = (move.at + size() - range->first) % size();
    ArcChain after = replaced(fitted_, at, move);
    for (std::size_t j = 1; j < after.arcs.size(); ++j) {
      if (after.arcs[j].arc.straight && after.arcs[j - 1].arc.straight) return {};
    }
    const std::optional<ChainFit> fit = fit_chain(after, points_, course_.noise_m, before->cost + kHopeless);
    if (!fit) return {};
    return Outcome{before->improbability - fit->improbability, *range, std::move(after)};
  }

  [[nodiscard]] ArcChain replaced(const ArcChain& chain, std::size_t at, const Move& move) const {
    ArcChain after = chain;
    const auto first = after.arcs.begin() + static_cast<long>(at), end = first + static_cast<long>(move.used);
    std::vector<PlacedArc> by;
    std::vector<double> ends_m{0.0};
    PlanePose pose = first->from;
    for (const Arc& arc : move.by) {
      by.push_back({arc, pose, {}});
      ends_m.push_back(ends_m.back() + arc.length_m);
      pose = end_of(arc, pose);
    }
    double was_m = 0.0, begins_m = 0.0;
    for (auto old = first; old != end; ++old) was_m += old->arc.length_m;
    for (auto old = first; old != end; begins_m += (old++)->arc.length_m) {
      const PlanePoint ahead = old->from.ahead();
      for (const std::size_t i : old->points) {
        const double along_m = foot_of(points_[i].at, old->arc, old->from, ahead).along_m;
        const double at_m = (begins_m + along_m) * ends_m.back() / was_m;
        const auto behind = std::upper_bound(ends_m.begin() + 1, ends_m.end() - 1, at_m);
        by[static_cast<std::size_t>(behind - ends_m.begin()) - 1].points.push_back(i);
      }
    }
    after.arcs.insert(after.arcs.erase(first, end), by.begin(), by.end());
    return after;
  }

  [[nodiscard]] Arc joined(std::size_t k, std::size_t used) const {
    Arc arc{0.0, 0.0};
    double turn = 0.0;
    for (std::size_t j = 0; j < used; ++j) {
      arc.length_m += placed(k + j).arc.length_m;
      turn += placed(k + j).arc.length_m * placed(k + j).arc.curvature_per_m;
    }
    arc.curvature_per_m = turn / arc.length_m;
    return arc;
  }

  /// The best neighbours first, those apart from each other in one pass.
  void merge_neighbours() {
    while (size() > kFewestArcs) {
      if (options_.progress) options_.progress(share_done_);
      std::vector<std::pair<double, std::size_t>> order;
      for (std::size_t k = 0; k + (course_.closed ? 0 : 1) < size(); ++k) {
        if (!merge_gain_[k]) {
          const std::optional<Outcome> outcome = outcome_of({k, 2, {joined(k, 2)}});
          merge_gain_[k] = outcome ? outcome->gain : 0.0;
        }
        if (*merge_gain_[k] > kLeastGain) order.push_back({*merge_gain_[k], k});
      }
      if (order.empty()) return;
      std::sort(order.rbegin(), order.rend());
      for (const std::size_t k : apart(order)) {
        const std::optional<Outcome> outcome = outcome_of({k, 2, {joined(k, 2)}});
        if (outcome && outcome->gain > kLeastGain) put(outcome->range, outcome->chain);
        else merge_gain_[k] = 0.0;
      }
    }
  }

  /// From the last to the first, so that a merge leaves the indices of the others; the best alone where it is at the
  /// end of the list, which putting turns.
  [[nodiscard]] std::vector<std::size_t> apart(const std::vector<std::pair<double, std::size_t>>& order) const {
    const std::size_t reach = kMargin + 2, best = order.front().second;
    const auto at_end = [&](std::size_t k) { return course_.closed && (k < reach || k + reach > size()); };
    if (at_end(best)) return {best};
    std::vector<std::size_t> taken;
    for (const auto& [gain, k] : order) {
      const bool free = std::all_of(taken.begin(), taken.end(), [&, k = k](std::size_t t) {
        return (t > k ? t - k : k - t) > 2 * reach;
      });
      if (free && !at_end(k)) taken.push_back(k);
    }
    std::sort(taken.rbegin(), taken.rend());
    return taken;
  }

  /// Of an arc between two that makes up for what their headings differ by, or bends as they do on the mean.
  [[nodiscard]] double bend_at_end(std::size_t k) const {
    const PlacedArc &a = placed(k), &b = placed(k + 1);
    const double twist = std::remainder(b.from.heading_rad - end_of(a.arc, a.from).heading_rad, 2.0 * M_PI);
    const double length_m = 0.2 * (a.arc.length_m + b.arc.length_m);
    return 0.5 * (a.arc.curvature_per_m + b.arc.curvature_per_m) + twist / length_m;
  }

  [[nodiscard]] std::vector<Move> moves_at(std::size_t k) const {
    std::vector<Move> moves;
    const Arc arc = placed(k).arc;
    if (arc.straight) moves.push_back({k, 1, {{arc.length_m, 0.0}}});
    if (course_.closed || k + 1 < size()) {
      const Arc next = placed(k + 1).arc, between{0.2 * (arc.length_m + next.length_m), bend_at_end(k)};
      Arc first = arc, last = next;
      first.length_m *= 0.8, last.length_m *= 0.8;
      moves.push_back({k, 2, {first, between, last}});
    }
    if (!arc.straight) {
      moves.push_back({k, 1, {{0.5 * arc.length_m, arc.curvature_per_m}, {0.5 * arc.length_m, arc.curvature_per_m}}});
      const Arc straight{0.5 * arc.length_m, 0.0, true}, rest{0.5 * arc.length_m, 1.5 * arc.curvature_per_m};
      moves.push_back({k, 1, {{arc.length_m, 0.0, true}}});
      moves.push_back({k, 1, {rest, straight}});
      moves.push_back({k, 1, {straight, rest}});
    }
    if (size() > 4 && (course_.closed || k + 2 < size())) {  // the middle one goes to both sides
      Arc first = arc, last = placed(k + 2).arc;
      const double half_m = 0.5 * placed(k + 1).arc.length_m;
      first.length_m += half_m, last.length_m += half_m;
      moves.push_back({k, 3, {first, last}});
    }
    for (std::size_t used = 1; used <= kMostJoined && size() >= used + 3; ++used) {
      const Arc one = joined(k, used), straight{0.25 * one.length_m, 0.0, true};
      if (used > 1) moves.push_back({k, used, {one}});
      moves.push_back({k, used, {straight, {0.5 * one.length_m, 2.0 * one.curvature_per_m}, straight}});
    }
    return moves;
  }

  bool try_moves_everywhere() {
    bool any = false;
    for (std::size_t k = 0; k < size(); ++k) {
      if (settled_[k]) continue;
      settled_[k] = true;
      Outcome best{kLeastGain, {}, {}};
      for (const Move& move : moves_at(k)) {
        std::optional<Outcome> outcome = outcome_of(move);
        if (outcome && outcome->gain > best.gain) best = std::move(*outcome);
      }
      if (best.gain <= kLeastGain) continue;
      put(best.range, best.chain);
      any = true;
    }
    return any;
  }

  // the whole ---------------------------------------------------------------------------------------------------------
  void refit() {
    fit_course(course_, points_);
    fitted_range_ = {};
  }

  /// Whether it has changed. Arcs that do not lie well yet say nothing beyond what the line has told.
  bool measure_noise() {
    if (!options_.noise_measured) return false;
    double freedom = 0.0;
    for (const PlacedArc& placed : course_.arcs) {
      freedom -= placed.arc.straight ? 1.0 : 2.0;
      for (const std::size_t i : placed.points) freedom += points_[i].weight;
    }
    const double squares = course_.squares / std::max(1.0, freedom);
    const double was = course_.noise_m;
    course_.noise_m = std::clamp(std::sqrt(squares), kLeastNoise_m, most_noise_m_);
    if (std::abs(course_.noise_m / was - 1.0) < kSameNoise) return false;
    std::fill(merge_gain_.begin(), merge_gain_.end(), std::nullopt);
    std::fill(settled_.begin(), settled_.end(), false);
    fitted_range_ = {};
    return true;
  }

  /// Cuts the arc beside the start and begins there.
  void begin_at_start() {
    std::size_t at = 0;
    double nearest = 1e300, along = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      const PlacedArc& arc = course_.arcs[k];
      const Foot foot = foot_of(course_.start, arc.arc, arc.from, arc.from.ahead());
      const double within = std::clamp(foot.along_m, 0.0, arc.arc.length_m);
      const double away = length(end_of({within, arc.arc.curvature_per_m}, arc.from).at - course_.start);
      if (away < nearest) nearest = away, at = k, along = within;
    }
    std::rotate(course_.arcs.begin(), course_.arcs.begin() + static_cast<long>(at), course_.arcs.end());
    PlacedArc& first = course_.arcs.front();
    if (along < kShortestPiece_m) return;
    PlacedArc last = first;
    last.arc.length_m = along;
    if (first.arc.length_m - along < kShortestPiece_m) {
      std::rotate(course_.arcs.begin(), course_.arcs.begin() + 1, course_.arcs.end());
      return;
    }
    first.from = end_of(last.arc, first.from);
    first.arc.length_m -= along;
    course_.arcs.push_back(last);
  }

  ArcCourse course_;
  const std::vector<WeightedPoint>& points_;
  const ArcSearchOptions& options_;
  std::vector<std::optional<double>> merge_gain_;  ///< of an arc with the next, where it is known
  std::vector<bool> settled_;                      ///< no other move helps
  Range fitted_range_{};
  ArcChain fitted_;
  std::optional<ChainFit> fit_;
  double share_done_ = 0.0;
  double most_noise_m_ = course_.noise_m;
};

}  // namespace

void fit_course(ArcCourse& course, const std::vector<WeightedPoint>& points) {
  VOLTLAP_DEMAND(!course.arcs.empty() && course.noise_m > 0.0);
  ArcChain whole{std::move(course.arcs), course.end, course.closed};
  const std::optional<ChainFit> fit = fit_chain(whole, points, course.noise_m);
  course.arcs = std::move(whole.arcs);
  course.end = whole.end;
  course.meets = fit && fit->meets;
  course.squares = 0.0;
  for (const PlacedArc& placed : course.arcs) {
    const PlanePoint ahead = placed.from.ahead();
    for (const std::size_t i : placed.points) {
      course.squares += points[i].weight * square(foot_of(points[i].at, placed.arc, placed.from, ahead).offset_m);
    }
  }
}

double information(const ArcCourse& course, std::size_t points) {
  VOLTLAP_DEMAND(points > 0);
  if (!course.meets) return std::numeric_limits<double>::infinity();
  double figures = 0.0;
  for (const PlacedArc& placed : course.arcs) figures += placed.arc.straight ? 1.0 : 2.0;
  const auto n = static_cast<double>(points);
  return n * std::log(std::max(square(kLeastNoise_m), course.squares / n)) + figures * std::log(n);
}

ArcCourse search_arcs(ArcCourse course, const std::vector<WeightedPoint>& points, const ArcSearchOptions& options) {
  VOLTLAP_DEMAND(!course.arcs.empty() && !points.empty() && course.noise_m > 0.0);
  ArcCourse found = ArcSearch(std::move(course), points, options).run();
  VOLTLAP_DEMAND(!found.arcs.empty());
  return found;
}

}  // namespace voltlap::plant
