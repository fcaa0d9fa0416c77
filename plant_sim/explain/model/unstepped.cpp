// SPDX-License-Identifier: Apache-2.0
#include "explain/model/unstepped.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "explain/gate/integrity.hpp"

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kLeastPasses = 2;
constexpr double kOneStep = 1.5;
constexpr double kToAndFro_s = 15.0;  // noise moves a reading to and fro; for longer it was further away

struct Change {
  double time_s, value;
  bool rises;
};
struct Pass {
  double time_s, value;
};

/// A thermistor passes the middle of two readings when its reading changes.
std::vector<Change> changes_of(const VectorXd& time_s, const VectorXd& values) {
  std::vector<Change> out;
  Index last = -1;
  for (Index row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values(row))) continue;
    if (last >= 0 && values(row) != values(last))
      out.push_back(
          {0.5 * (time_s(last) + time_s(row)), 0.5 * (values(last) + values(row)), values(row) > values(last)});
    last = row;
  }
  return out;
}

/// When the thermistor passed each middle: in the midst of the changes to and fro, so that the reading is as long
/// on one side before as on the other after. Changes that end where they began are no pass; those to and fro that
/// begin or end within kToAndFro_s of the recording's `begin_s` or `end_s` are one in part.
std::vector<Pass> passes_of(const std::vector<Change>& changes, double begin_s, double end_s) {
  std::vector<Pass> out;
  for (std::size_t first = 0; first < changes.size();) {
    std::size_t end = first + 1;
    double back_s = 0.0;  // time spent again where it came from
    while (end < changes.size() && changes[end].value == changes[first].value &&
           changes[end].time_s - changes[end - 1].time_s < kToAndFro_s) {
      if (changes[end].rises == changes[first].rises) back_s += changes[end].time_s - changes[end - 1].time_s;
      ++end;
    }
    const bool whole = end - first == 1 || (changes[first].time_s - begin_s > kToAndFro_s &&
                                            end_s - changes[end - 1].time_s > kToAndFro_s);
    if (whole && (end - first) % 2 == 1) out.push_back({changes[first].time_s + back_s, changes[first].value});
    first = end;
  }
  return out;
}

/// Takes the steps away; the times at which a middle was passed, or none where the values stay as they are.
std::vector<double> unstep(const VectorXd& read_s, Passes which, VectorXd& values) {
  const double step = least_change(values);
  if (read_s.size() == 0) return {};
  constexpr double kAnyTime_s = 1e300;
  const bool whole = which == Passes::kWhole;
  const std::vector<Pass> passes = passes_of(changes_of(read_s, values), whole ? read_s(0) : -kAnyTime_s,
                                             whole ? read_s(read_s.size() - 1) : kAnyTime_s);
  if (!(step > kCoarse_k) || passes.size() < kLeastPasses) return {};
  std::vector<double> passed_s;
  for (const Pass& pass : passes) passed_s.push_back(pass.time_s);
  std::size_t next = 0;
  for (Index row = 0; row < values.size(); ++row) {
    while (next < passes.size() && passes[next].time_s <= read_s(row)) ++next;
    // What jumps by more than a step passed nothing: a unit that begins with 0 degC until it has measured.
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
