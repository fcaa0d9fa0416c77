// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/refine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voltlap::explain {
namespace {

constexpr int kSteps = 8;  // of Gauss-Newton, at most; it ends where a step changes next to nothing:
constexpr double kOfSigma = 0.1, kOfSize = 0.003;
constexpr double kLeastPart = 0.05;  // of a step
constexpr double kFiner = 0.2;       // of the least noise that decides: where sizes are told
constexpr double kInside = 0.5;      // of the range, where a set begins whose straight line is larger than can be
constexpr double kSpoils = 1.21;     // of the squares of a channel where it was not fitted
constexpr double kSure = 2.0;        // standard deviations

/// A step may have left what is physically possible. What no step estimates stays what the form makes of it.
void hold_inside(const Family& family, const std::vector<plant::Cause>& causes, std::size_t member,
                 std::vector<double>& values) {
  const plant::Cause& cause = causes[static_cast<std::size_t>(family.suspects[member].cause)];
  for (const std::size_t p : family.suspects[member].form.refined) {
    values[p] = std::clamp(values[p], cause.parameters[p].low, cause.parameters[p].high);
  }
}

/// Does every channel stay as good as it was where it was not fitted, but for less than a practical size?
bool spoils_nothing(const Family& family, const Fit& fit, const Fit& nothing) {
  for (std::size_t c = 0; c < family.problem.channels.size(); ++c) {
    const auto row = static_cast<Index>(c);
    const double least = family.practical[c];
    const double allowed = family.problem.channels[c].all[0].count * least * least;
    if (fit.left.row(row).sum() > kSpoils * nothing.left.row(row).sum() + allowed) return false;
  }
  return true;
}

/// Sizes of a finer noise may follow what is fast and leave what is slow to the noise, as those of a curve can:
/// they are told only where they leave no more of any channel.
bool foresees_as_well(const Fit& finer, const Fit& fit) {
  constexpr double kAsWell = 1.05;  // of the squares
  return (finer.left.rowwise().sum().array() <= kAsWell * fit.left.rowwise().sum().array()).all();
}

/// Is each size sure to be more than nothing? Time constants are only ever near one.
bool is_sure(const std::vector<plant::Cause>& causes, const Family& family, const Set& set) {
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const plant::Cause& cause = causes[static_cast<std::size_t>(family.suspects[set.members[m]].cause)];
    bool one = false, any = false;
    for (const std::size_t p : family.suspects[set.members[m]].form.refined) {
      if (cause.parameters[p].low > 0.0) continue;
      any = true;
      one = one || std::abs(set.values[m][p]) > kSure * set.sigma[m][p];
    }
    if (any && !one) return false;
  }
  return true;
}

/// Does another step change nothing that anyone would see?
bool is_settled(const std::vector<std::vector<double>>& before, const Set& set) {
  for (std::size_t m = 0; m < before.size(); ++m) {
    for (std::size_t p = 0; p < before[m].size(); ++p) {
      const double allowed = std::max(kOfSigma * set.sigma[m][p], kOfSize * std::abs(set.values[m][p]));
      if (std::abs(set.values[m][p] - before[m][p]) > allowed) return false;
    }
  }
  return true;
}

/// Values of the parameters of a set, and where the log began beside them.
struct Point {
  std::vector<std::vector<double>> values;
  VectorXd starts;
};

/// A part of the way.
Point towards(const Point& from, const Point& to, double part) {
  Point out = to;
  for (std::size_t m = 0; m < out.values.size(); ++m) {
    for (std::size_t p = 0; p < out.values[m].size(); ++p)
      out.values[m][p] = from.values[m][p] + part * (to.values[m][p] - from.values[m][p]);
  }
  if (from.starts.size() == to.starts.size()) out.starts = from.starts + part * (to.starts - from.starts);
  return out;
}

/// A set with its sizes after a step, and what the point is worth that it began at [ln evidence beyond nothing].
struct Step {
  Set set;
  double worth;
};

class Refinement {
 public:
  Refinement(const std::vector<plant::Cause>& causes, const Family& family, const Fit& nothing,
             const AtValues& at_values)
      : causes_(causes), family_(family), nothing_(nothing), at_values_(at_values) {}

  /// The step from a point, by the straight line that is tangent there.
  [[nodiscard]] Step from(const Set& set, const Point& at) const {
    std::vector<std::vector<std::size_t>> parameters;
    for (const std::size_t m : set.members) parameters.push_back(family_.suspects[m].form.refined);
    Step out{set, 0.0};
    Family there = at_values_({set.members, at.values, at.starts});
    there.asked = family_.asked;
    out.worth = lead_of(fit_of(there.problem, {}), nothing_).ln;
    out.set.fit = fit_of(there.problem, columns_of(there, set.members));
    // What is too small to decide still tells how large a cause is.
    for (double& sigma : there.problem.least_sigma) sigma *= kFiner;
    const Fit finer = fit_of(there.problem, columns_of(there, set.members));
    const Fit& told = foresees_as_well(finer, out.set.fit) ? finer : out.set.fit;
    put_values(there, told, at.values, parameters, out.set);
    out.set.fit.plain_starts = told.plain_starts;  // where it began goes with the sizes
    hold(out.set);
    out.set.lead = lead_of(out.set.fit, nothing_);
    out.set.use = use_of(there, out.set.fit, nothing_);
    return out;
  }

  void hold(Set& set) const {
    for (std::size_t m = 0; m < set.members.size(); ++m)
      hold_inside(family_, causes_, set.members[m], set.values[m]);
  }

  /// Where a set begins whose straight line is larger than can be: a part of the way to what can.
  void begin_inside(Set& set) const {
    for (std::size_t m = 0; m < set.members.size(); ++m) {
      const std::vector<double> before = set.values[m];
      hold_inside(family_, causes_, set.members[m], set.values[m]);
      if (set.values[m] == before) continue;
      for (const std::size_t p : family_.suspects[set.members[m]].form.refined) set.values[m][p] *= kInside;
    }
  }

 private:
  const std::vector<plant::Cause>& causes_;
  const Family& family_;
  const Fit& nothing_;
  const AtValues& at_values_;
};

/// Steps until one changes next to nothing, each from a point that is worth more than the last. A curve and the charge
/// that a rest tells by it can throw each other to and fro, or away from where they are best.
Set followed(const Refinement& refinement, Set set) {
  Point at{set.values, set.fit.plain_starts}, best_at = at;
  Step best{std::move(set), -std::numeric_limits<double>::infinity()};
  double part = 1.0;
  for (int step = 0; step < kSteps && part > kLeastPart; ++step) {
    Step next = refinement.from(best.set, at);
    if (next.worth < best.worth) {
      part *= 0.5;
    } else {
      if (is_settled(at.values, next.set)) return std::move(next.set);
      best = std::move(next);
      best_at = std::move(at);
    }
    at = towards(best_at, {best.set.values, best.set.fit.plain_starts}, part);
  }
  best.set.values = std::move(at.values);
  best.set.fit.plain_starts = std::move(at.starts);
  return std::move(best.set);
}

}  // namespace

Set refined(const std::vector<plant::Cause>& causes, const Family& family, const Fit& nothing, const Set& set,
            const AtValues& at_values) {
  const Refinement refinement(causes, family, nothing, at_values);
  Set begun = set;
  if (set.bends) refinement.begin_inside(begun);
  refinement.hold(begun);
  Set out = followed(refinement, std::move(begun));
  out.stands = set.stands || set.bends;
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const plant::Cause& cause = causes[static_cast<std::size_t>(family.suspects[set.members[m]].cause)];
    for (const std::size_t p : family.suspects[set.members[m]].form.refined)
      out.stands = out.stands && plant::is_inside_prior(cause.parameters[p], out.values[m][p]);
  }
  out.stands = out.stands && out.lead.decisive && takes_enough(family, out, nothing) && is_sure(causes, family, out) &&
               is_at_home(causes, family, out) && spoils_nothing(family, out.fit, nothing);
  return out;
}

}  // namespace voltlap::explain
