// SPDX-License-Identifier: Apache-2.0
#include "explain/gate/frozen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kFrozen = 3.0;       // s of one value under a moving current
constexpr double kFrozenTurns = 3.0;  // times as long as the value usually stands

/// How long a value usually stands: a slow scan of many cells repeats each until its next turn.
double usual_stand_s(const VectorXd& time, const VectorXd& values) {
  std::vector<double> stands;
  Index first = 0;
  for (Index row = 1; row < values.size(); ++row) {
    if (values(row) == values(first)) continue;
    if (std::isfinite(values(first))) stands.push_back(time(row) - time(first));
    first = row;
  }
  return median(std::move(stands));
}

}  // namespace

void mask(Recording& log, const Sensor& sensor, Index first, Index last, const std::string& why) {
  for (Index row = first; row < last; ++row) sensor.values(row) = std::numeric_limits<double>::quiet_NaN();
  log.masked.push_back({sensor.role, log.time_s(first), log.time_s(last - 1), why});
}

void mask_frozen(Recording& log, const Sensor& sensor, const Neighbour& neighbour,
                 std::vector<GateFinding>& findings) {
  const auto& [role, values, unit] = sensor;
  const auto& [moving, moved_by] = neighbour;
  double total = 0.0;
  const double least = std::max(kFrozen, kFrozenTurns * usual_stand_s(log.time_s, values));
  for (Index row = 0; row + 1 < values.size();) {
    Index last = row + 1;
    double low = moving(row), high = moving(row);
    while (last < values.size() && values(last) == values(row)) {
      low = std::min(low, moving(last));
      high = std::max(high, moving(last));
      ++last;
    }
    const double seconds = log.time_s(last - 1) - log.time_s(row);
    if (last - row >= 10 && seconds >= least && high - low > moved_by && std::isfinite(values(row))) {
      mask(log, sensor, row, last, fmt::format("frozen at {:.4g} {} while its neighbours move", values(row), unit));
      total += seconds;
    }
    row = last;
  }
  if (total > 0.0) findings.push_back({"frozen_signal", role, "duration_s", total, "s", true});
}

namespace {

/// Does the current read one value for nearly all of these rows? Then they are a rest, and without noise a rest
/// stands.
bool rests_exactly(const VectorXd& current, Index first, Index last) {
  const auto same =
      static_cast<double>((current.segment(first, last - first).array() == current((first + last) / 2)).count());
  return same > 0.9 * static_cast<double>(last - first);
}

/// Does it go up and down from step to step, as what is noisy does, and not up or down for long? By more than its
/// least step now and then: what only goes to and fro between two readings has coarser steps than noise.
bool is_noisy(const VectorXd& values) {
  constexpr double kOften = 0.1;  // of the steps; half of them where there is nothing but noise
  constexpr double kMore = 1.5, kNowAndThen = 0.02;  // times the least step; of the steps, as noise of 0.3 of one has
  double last = std::numeric_limits<double>::quiet_NaN(), step = 0.0, turns = 0.0;
  std::vector<double> steps;
  for (const double v : values) {
    if (!std::isfinite(v) || v == last) continue;
    if (step * (v - last) < 0.0) turns += 1.0;
    if (std::isfinite(last)) step = v - last, steps.push_back(std::abs(step));
    last = v;
  }
  if (steps.empty()) return false;
  const double least = *std::min_element(steps.begin(), steps.end());
  const auto more = std::count_if(steps.begin(), steps.end(), [&](double s) { return s > kMore * least; });
  const auto all = static_cast<double>(steps.size());
  return turns > kOften * all && static_cast<double>(more) > kNowAndThen * all;
}

}  // namespace

void mask_standing(Recording& log, const Sensor& sensor, std::vector<GateFinding>& findings) {
  const auto& [role, values, unit] = sensor;
  constexpr double kTimesLonger = 4.0, kOften = 0.05;  // of the next longest stand; of the time
  constexpr Index kLeastRows = 30;
  struct Stand {
    Index first, last;
    double seconds;
  };
  std::vector<Stand> stands;
  double standing = 0.0, moving = 0.0;
  for (Index row = 0; row < values.size();) {
    Index last = row + 1;
    while (last < values.size() && values(last) == values(row)) ++last;
    if (std::isfinite(values(row))) {
      stands.push_back({row, last, log.time_s(last - 1) - log.time_s(row)});
      (last - row < kLeastRows ? moving : standing) += static_cast<double>(last - row);
    }
    row = last;
  }
  if (stands.size() < 2 || !is_noisy(values)) return;
  std::partial_sort(stands.begin(), stands.begin() + 2, stands.end(),
                    [](const Stand& a, const Stand& b) { return a.seconds > b.seconds; });
  const Stand& longest = stands[0];
  const auto rows = static_cast<double>(longest.last - longest.first);
  if (role != "current" && rests_exactly(*log.find("current"), longest.first, longest.last)) return;
  if (longest.last - longest.first < kLeastRows || longest.seconds < kFrozen ||
      longest.seconds < kTimesLonger * stands[1].seconds || standing - rows > kOften * (standing - rows + moving)) {
    return;
  }
  mask(log, sensor, longest.first, longest.last,
       fmt::format("frozen at {:.4g} {}: four times as long as it ever stands otherwise", values(longest.first),
                   unit));
  findings.push_back({"frozen_signal", role, "duration_s", longest.seconds, "s", true});
}

}  // namespace voltlap::plant
