// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/laps.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "race/track/import/smooth_path.hpp"

namespace voltlap::plant {
namespace {

constexpr double kShortestLap_m = 30.0;
constexpr double kFollowed_m = 60.0;
constexpr double kBetweenLines_m = 5.0;
constexpr double kSameLength = 0.05;

class LapFinder {
 public:
  LapFinder(const PointList& path, double reach_m)
      : path_(path), along_(distances_along(path, false)), reach_m_(reach_m) {}

  /// Laps with the line across the path at point `at`.
  [[nodiscard]] std::vector<Lap> laps_from(std::size_t at) const {
    std::vector<std::size_t> crossings = crossings_of(at);
    std::vector<Lap> laps;
    std::vector<double> lengths;
    for (std::size_t k = 1; k < crossings.size(); ++k) {
      laps.push_back({crossings[k - 1], crossings[k], along_[crossings[k]] - along_[crossings[k - 1]]});
      lengths.push_back(laps.back().length_m);
    }
    const double usual = median(lengths);
    std::erase_if(laps, [&](const Lap& lap) { return std::abs(lap.length_m - usual) > kSameLength * usual; });
    return laps;
  }

  [[nodiscard]] const std::vector<double>& along() const { return along_; }

 private:
  /// Direction of the way over the next metres.
  [[nodiscard]] PlanePoint direction(std::size_t at) const {
    std::size_t to = at + 1, from = at;
    while (to + 1 < path_.size() && along_[to] - along_[at] < 0.5 * reach_m_) ++to;
    to = std::min(to, path_.size() - 1);
    while (from > 0 && along_[to] - along_[from] < 0.5 * reach_m_) --from;
    const PlanePoint way = path_[to] - path_[from];
    return (1.0 / std::max(1e-9, length(way))) * way;
  }

  [[nodiscard]] PlanePoint at_distance(double distance) const {
    const auto above = std::upper_bound(along_.begin() + 1, along_.end() - 1, distance);
    const auto k = static_cast<std::size_t>(above - along_.begin());
    const double piece = along_[k] - along_[k - 1];
    const double f = piece > 0.0 ? std::clamp((distance - along_[k - 1]) / piece, 0.0, 1.0) : 0.0;
    return (1.0 - f) * path_[k - 1] + f * path_[k];
  }

  /// Whether the way behind `again` is the way behind `first`; as far as the recording goes.
  [[nodiscard]] bool follows(double first, double again) const {
    const double most = std::min(kFollowed_m, 0.5 * (again - first));
    for (double way = 5.0; way <= most && again + way <= along_.back(); way += 5.0) {
      // Two recordings of a bend differ in length: the nearest place counts, not the one as far along.
      double away = 1e9;
      for (double shift = -0.1 * way - 2.0; shift <= 0.1 * way + 2.0; shift += 1.0) {
        away = std::min(away, length(at_distance(again + way) - at_distance(first + way + shift)));
      }
      if (away > reach_m_) return false;
    }
    return true;
  }

  /// Points behind which the path crosses the line at `at` in its direction; `at` is the first.
  [[nodiscard]] std::vector<std::size_t> crossings_of(std::size_t at) const {
    const PlanePoint line = path_[at], way = direction(at);
    std::vector<std::size_t> crossings{at};
    for (std::size_t i = at + 1; i < path_.size(); ++i) {
      if (along_[i] - along_[crossings.back()] < kShortestLap_m) continue;
      const PlanePoint from = path_[i - 1] - line, to = path_[i] - line;
      const double before = dot(from, way), behind = dot(to, way);
      if (!(before < 0.0 && behind >= 0.0)) continue;
      const double share = -before / (behind - before);
      const double beside = cross(way, (1.0 - share) * from + share * to);
      const PlanePoint step = to - from;
      if (std::abs(beside) > reach_m_ || dot(step, way) < 0.5 * length(step)) continue;
      if (follows(along_[at], along_[i - 1] + share * length(step))) crossings.push_back(i);
    }
    return crossings;
  }

  const PointList& path_;
  std::vector<double> along_;
  double reach_m_;
};

double covered(const std::vector<Lap>& laps) {
  double sum = 0.0;
  for (const Lap& lap : laps) sum += lap.length_m;
  return sum;
}

}  // namespace

std::vector<Lap> find_laps(const PointList& path, double reach_m) {
  VOLTLAP_DEMAND(path.size() >= 4 && reach_m > 0.0);
  const LapFinder finder(path, reach_m);
  std::vector<Lap> best;
  double tried_at = -kBetweenLines_m;
  for (std::size_t at = 0; at + 1 < path.size(); ++at) {
    if (finder.along()[at] - tried_at < kBetweenLines_m) continue;
    tried_at = finder.along()[at];
    if (finder.along().back() - tried_at < covered(best)) break;  // what is left is shorter
    std::vector<Lap> laps = finder.laps_from(at);
    if (covered(laps) > 1.02 * covered(best)) best = std::move(laps);
  }
  return best;
}

}  // namespace voltlap::plant
