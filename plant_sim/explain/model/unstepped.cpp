// SPDX-License-Identifier: Apache-2.0
#include "explain/model/unstepped.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "explain/gate/integrity.hpp"

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kLeastPasses = 2;
constexpr double kOneStep = 1.5, kFurthest = 2.5;
constexpr double kWindow_s = 15.0;  // to each side: noise moves a reading to and fro, laps move it for longer
constexpr double kStood_s = 5.0;    // a reading that is no chance one

/// A thermistor passes the middle of two readings when its reading changes over it.
struct Change {
  double time_s;
  bool rises, jumps;
};
struct Pass {
  double time_s, value;
};

std::vector<double> middles_of(const VectorXd& values) {
  std::set<double> levels;
  for (const double v : values)
    if (std::isfinite(v)) levels.insert(v);
  std::vector<double> out;
  for (auto next = levels.begin(), last = next; next != levels.end(); last = next++)
    if (next != last) out.push_back(0.5 * (*last + *next));
  return out;
}

/// Of each middle its changes. What goes further than noise does, jumps: a unit that begins with 0 degC until it has
/// measured.
std::vector<std::vector<Change>> changes_of(const VectorXd& time_s, const VectorXd& values,
                                            const std::vector<double>& middles, double furthest) {
  std::vector<std::vector<Change>> out(middles.size());
  Index last = -1;
  for (Index row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values(row))) continue;
    if (last >= 0 && values(row) != values(last)) {
      const auto [low, high] = std::minmax(values(row), values(last));
      const bool rises = values(row) > values(last), jumps = high - low >= furthest;
      const auto first = std::ranges::lower_bound(middles, low), end = std::ranges::lower_bound(middles, high);
      for (auto middle = first; middle != end; ++middle)
        out[static_cast<std::size_t>(middle - middles.begin())].push_back(
            {0.5 * (time_s(last) + time_s(row)), rises, jumps});
    }
    last = row;
  }
  return out;
}

/// What is above a middle less what is below it, over a window about each time, is a broken line: at its corners one
/// end of the window meets a change. Before the first and after the last change the reading stays as it is.
struct Corner {
  double time_s, slope;  ///< to the next corner
};

std::vector<Corner> corners_of(const std::vector<Change>& changes) {
  std::vector<Corner> out;
  for (const Change& change : changes) {
    const double slope = change.rises ? 2.0 : -2.0;
    out.push_back({change.time_s - kWindow_s, slope});
    out.push_back({change.time_s + kWindow_s, -slope});
  }
  std::ranges::stable_sort(out, {}, &Corner::time_s);
  return out;
}

/// Where that line is nought, as many readings are above the middle as below it: there a thermistor with noise is at
/// the middle, however slowly it goes there and however often. What turns back within the window is not at it.
std::vector<double> noughts_of(const std::vector<Change>& changes) {
  std::vector<double> out;
  if (changes.empty()) return out;
  const std::vector<Corner> corners = corners_of(changes);
  double line = changes.front().rises ? -2.0 * kWindow_s : 2.0 * kWindow_s, slope = 0.0;
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    slope += corners[k].slope;
    const double next = line + slope * (corners[k + 1].time_s - corners[k].time_s);
    if (line != 0.0 && line * next <= 0.0) out.push_back(corners[k].time_s - line / slope);
    line = next;
  }
  return out;
}

/// Is a nought a pass? Not beside a jump, nor where the recording begins or ends within the window: what was before it
/// is not known. A single change tells its time alone, when the reading has stood for a while before and after it.
bool is_pass(double at_s, const std::vector<Change>& changes, double begin_s, double end_s, Passes which) {
  const auto first = std::ranges::lower_bound(changes, at_s - kWindow_s, {}, &Change::time_s);
  const auto last = std::ranges::upper_bound(changes, at_s + kWindow_s, {}, &Change::time_s);
  if (std::any_of(first, last, [](const Change& change) { return change.jumps; })) return false;
  if (which == Passes::kAny) return true;
  const double stood_s = last - first == 1 ? kStood_s : kWindow_s;
  return at_s - begin_s > stood_s && end_s - at_s > stood_s;
}

/// When the thermistor was at each middle, in order of time.
std::vector<Pass> passes_of(const VectorXd& read_s, const VectorXd& values, double step, Passes which) {
  const std::vector<double> middles = middles_of(values);
  const std::vector<std::vector<Change>> changes = changes_of(read_s, values, middles, kFurthest * step);
  std::vector<Pass> out;
  for (std::size_t m = 0; m < middles.size(); ++m)
    for (const double at_s : noughts_of(changes[m]))
      if (is_pass(at_s, changes[m], read_s(0), read_s(read_s.size() - 1), which)) out.push_back({at_s, middles[m]});
  std::ranges::stable_sort(out, {}, &Pass::time_s);
  return out;
}

/// Takes the steps away; the times at which a middle was passed, or none where the values stay as they are.
std::vector<double> unstep(const VectorXd& read_s, Passes which, VectorXd& values) {
  const double step = least_change(values);
  if (read_s.size() == 0 || !(step > kCoarse_k)) return {};
  const std::vector<Pass> passes = passes_of(read_s, values, step, which);
  if (passes.size() < kLeastPasses) return {};
  std::vector<double> passed_s;
  for (const Pass& pass : passes) passed_s.push_back(pass.time_s);
  std::size_t next = 0;
  for (Index row = 0; row < values.size(); ++row) {
    while (next < passes.size() && passes[next].time_s <= read_s(row)) ++next;
    const double by =
        next > 0 && next < passes.size() ? std::abs(passes[next].value - passes[next - 1].value) : 0.0;
    const bool between = by > 0.0 && by < kOneStep * step;
    if (!between || !std::isfinite(values(row))) {
      values(row) = std::nan("");
      continue;
    }
    const Pass &a = passes[next - 1], &b = passes[next];
    values(row) = a.value + (read_s(row) - a.time_s) / (b.time_s - a.time_s) * (b.value - a.value);
  }
  return passed_s;
}

}  // namespace

double least_change(const VectorXd& values) {
  double out = std::numeric_limits<double>::infinity(), last = std::nan("");
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    if (v != last && std::isfinite(last)) out = std::min(out, std::abs(v - last));
    last = v;
  }
  return out;
}

plant::Recording unstepped(plant::Recording log, Passes passes) {
  for (const std::string& role : log.numbered("temperature_")) {
    const auto read = log.read_s.find(role);
    std::vector<double> passed_s =
        unstep(read == log.read_s.end() ? log.time_s : read->second, passes, log.signals[role]);
    if (!passed_s.empty()) log.passed_s[role] = std::move(passed_s);
  }
  return log;
}

bool was_read_in_steps(const plant::Recording& log, const std::string& role) {
  const auto values = log.signals.find(role);
  return log.passed_s.count(role) > 0 || (values != log.signals.end() && is_coarse(values->second));
}

double step_error(const plant::Recording& log, const std::vector<std::string>& roles) {
  double least = 1e300;
  for (const std::string& role : roles) least = std::min(least, plant::step_of(*log.find(role)));
  return least < 1e300 ? least / std::sqrt(12.0) : 0.0;
}

double step_error_of_heat(const plant::Recording& read) {
  constexpr double kUsual_k = 1.0;
  double least = kUsual_k;
  const std::vector<std::string> roles = read.numbered("temperature_");
  bool tells = false;
  for (const std::string& role : roles) {
    const double step = least_change(*read.find(role));
    if (std::isfinite(step)) least = tells ? std::min(least, step) : step;
    tells = tells || std::isfinite(step);
  }
  return roles.empty() ? 0.0 : least / std::sqrt(12.0);
}

}  // namespace voltlap::explain
