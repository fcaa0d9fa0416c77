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
constexpr double kToAndFro_s = 15.0;  // noise moves a reading to and fro; for longer it was further away
constexpr double kOnOtherSide = 0.1;  // a tenth of the readings: 1.3 times the noise away
constexpr double kStays = 2.0;        // of the way from the middle before: it hovered there, and passed at no time

/// A thermistor passes the middle of two readings when its reading changes over it.
struct Change {
  double time_s;
  bool rises;
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

/// Of each middle its changes. What jumps further than noise does passed nothing: a unit that begins with 0 degC until
/// it has measured.
std::vector<std::vector<Change>> changes_of(const VectorXd& time_s, const VectorXd& values,
                                            const std::vector<double>& middles, double furthest) {
  std::vector<std::vector<Change>> out(middles.size());
  Index last = -1;
  for (Index row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values(row))) continue;
    if (last >= 0 && values(row) != values(last) && std::abs(values(row) - values(last)) < furthest) {
      const auto [low, high] = std::minmax(values(row), values(last));
      const auto first = std::ranges::lower_bound(middles, low), end = std::ranges::lower_bound(middles, high);
      for (auto middle = first; middle != end; ++middle)
        out[static_cast<std::size_t>(middle - middles.begin())].push_back(
            {0.5 * (time_s(last) + time_s(row)), values(row) > values(last)});
    }
    last = row;
  }
  return out;
}

/// Changes to and fro about one middle.
struct Group {
  double first_s, last_s, value;
  bool rises;              ///< first
  double back_s = 0.0;  ///< spent again where it came from
  int changes = 1;
};

/// What noise does to a slow thermistor, it does for longer: as long as changes have gone to and fro so far, the next
/// of them may be away. A swing that passes a middle again without noise is not slow.
void add_groups(double middle, const std::vector<Change>& changes, std::vector<Group>& out) {
  const std::size_t begin = out.size();
  for (const Change& now : changes) {
    if (out.size() == begin ||
        now.time_s - out.back().last_s >= std::max(kToAndFro_s, out.back().last_s - out.back().first_s)) {
      out.push_back({now.time_s, now.time_s, middle, now.rises});
      continue;
    }
    Group& group = out.back();
    if (now.rises == group.rises) group.back_s += now.time_s - group.last_s;
    group.last_s = now.time_s;
    ++group.changes;
  }
}

/// Of all middles, as they begin.
std::vector<Group> groups_of(const VectorXd& time_s, const VectorXd& values, double furthest) {
  const std::vector<double> middles = middles_of(values);
  const std::vector<std::vector<Change>> changes = changes_of(time_s, values, middles, furthest);
  std::vector<Group> out;
  for (std::size_t m = 0; m < middles.size(); ++m) add_groups(middles[m], changes[m], out);
  std::ranges::stable_sort(out, {}, &Group::first_s);
  return out;
}

bool passes(const Group& group) { return group.changes % 2 == 1; }

/// Time from another middle passed before, or to one passed after where there is none; infinite without both.
double way_s(const std::vector<Group>& groups, std::size_t k) {
  const auto other = [&](std::size_t i) { return passes(groups[i]) && groups[i].value != groups[k].value; };
  for (std::size_t i = k; i-- > 0;)
    if (other(i)) return groups[k].first_s - groups[i].first_s;
  for (std::size_t i = k + 1; i < groups.size(); ++i)
    if (other(i)) return groups[i].last_s - groups[k].last_s;
  return std::numeric_limits<double>::infinity();
}

/// Of the readings from `begin_s` to `end_s`, the part above the middle.
double part_above(double middle, const VectorXd& time_s, const VectorXd& values, double begin_s, double end_s) {
  double above = 0.0, all = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    if (time_s(row) < begin_s || time_s(row) > end_s || !std::isfinite(values(row))) continue;
    all += 1.0;
    above += values(row) > middle ? 1.0 : 0.0;
  }
  return all > 0.0 ? above / all : 0.0;
}

/// The recording neither begins nor ends amid the changes to and fro: in its first and last kToAndFro_s the reading is
/// on its side of the middle.
bool is_whole(const Group& group, const VectorXd& time_s, const VectorXd& values) {
  const double begin_s = time_s(0), end_s = time_s(time_s.size() - 1);
  const double first = part_above(group.value, time_s, values, begin_s, begin_s + kToAndFro_s);
  const double last = part_above(group.value, time_s, values, end_s - kToAndFro_s, end_s);
  const double begins_beyond = group.rises ? first : 1.0 - first, ends_before = group.rises ? 1.0 - last : last;
  return (group.first_s - begin_s > kToAndFro_s || begins_beyond < kOnOtherSide) &&
         (end_s - group.last_s > kToAndFro_s || ends_before < kOnOtherSide);
}

/// When the thermistor passed each middle: in the midst of the changes to and fro, so that the reading is as long
/// on one side before as on the other after. Changes that end where they began are no pass; those to and fro that the
/// recording begins or ends amid are one in part.
std::vector<Pass> passes_of(const VectorXd& read_s, const VectorXd& values, double step, Passes which) {
  std::vector<Pass> out;
  const std::vector<Group> groups = groups_of(read_s, values, kFurthest * step);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Group& group = groups[k];
    if (!passes(group)) continue;
    const bool settled = group.last_s - group.first_s < std::max(kToAndFro_s, kStays * way_s(groups, k));
    if (which == Passes::kAny || group.changes == 1 || (settled && is_whole(group, read_s, values)))
      out.push_back({group.first_s + group.back_s, group.value});
  }
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
