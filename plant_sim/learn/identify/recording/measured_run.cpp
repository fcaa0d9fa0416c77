// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/measured_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kRestShare = 0.01;  // of the largest current

/// Rows that are means (hold kLinear) and have a step of the current inside: their mean voltage is not that of their
/// mean current, by up to an eighth of a row's rise of the branches.
bool has_step_inside(const CellLog& log, std::size_t row, double most) {
  constexpr double kStep = 0.02;  // of the largest current
  if (row < 2 || row + 2 >= log.rows()) return false;
  const auto change = [&](std::size_t at) { return log.current_a[at] - log.current_a[at - 1]; };
  const bool between = change(row) * change(row + 1) > 0.0 && std::abs(change(row)) > kStep * most &&
                       std::abs(change(row + 1)) > kStep * most;
  return between && std::abs(change(row - 1)) < kStep * most && std::abs(change(row + 2)) < kStep * most;
}

}  // namespace

double largest_current(const CellLog& log) {
  double most = 0.0;
  for (const double i : log.current_a) most = std::max(most, std::abs(i));
  return most;
}

std::vector<bool> resting_rows(const CellLog& log) {
  const double threshold = kRestShare * largest_current(log);
  std::vector<bool> out(log.rows());
  for (std::size_t row = 0; row < log.rows(); ++row) out[row] = std::abs(log.current_a[row]) <= threshold;
  return out;
}

std::vector<std::size_t> full_charges(const CellLog& log) {
  VOLTLAP_DEMAND(log.rows() > 0 && log.voltage_v.size() == log.rows());
  // A full charge is one that ends within this of the highest voltage at which the cell rests or is charged for long:
  // what a braking car pushes it to for a moment is higher.
  constexpr double kFullBand = 0.03, kLeastCharge = 120.0;
  const double most = largest_current(log);
  const std::vector<bool> resting = resting_rows(log);
  double rest_high = 0.0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (resting[row] && std::isfinite(log.voltage_v[row])) rest_high = std::max(rest_high, log.voltage_v[row]);
  }
  struct Charge {
    std::size_t end;
    double top_v;
  };
  std::vector<Charge> charges;
  double charging_s = 0.0, top = 0.0, high = rest_high;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    if (log.current_a[row] < -kRestShare * most) {
      charging_s += log.time_s[row] - log.time_s[row - 1];
      top = std::max(top, std::isfinite(log.voltage_v[row]) ? log.voltage_v[row] : 0.0);
      continue;
    }
    // The taper's tail may run on below the threshold: the anchor is where its current has died.
    if (charging_s > kLeastCharge) charges.push_back({row - 1, top});
    charging_s = top = 0.0;
  }
  if (charging_s > kLeastCharge) high = std::max(high, top);  // it goes on beyond the recording
  for (const Charge& charge : charges) high = std::max(high, charge.top_v);
  std::vector<std::size_t> rows;
  if (resting[0] && log.voltage_v[0] > rest_high - kFullBand) rows.push_back(0);
  for (const Charge& charge : charges) {
    if (charge.top_v > high - 0.5 * kFullBand) rows.push_back(charge.end);
  }
  return rows;
}

namespace {

Eigen::Map<const Eigen::VectorXd> column(const std::vector<double>& values) {
  return {values.data(), static_cast<Index>(values.size())};
}

struct CountedSoc {
  Eigen::VectorXd soc;
  std::vector<std::pair<Index, Index>> unknown;  ///< rows first to last (inclusive) of which it is not known
};

/// By the charge drawn since the anchor; 1 again at each later full charge. What a cycle does not close by is divided
/// over its charge; where that is more than a counter loses, charge was put back that nobody recorded, and from the
/// lowest point on the SOC is not known.
CountedSoc counted_soc(const CellLog& log, const RunOptions& options) {
  constexpr double kLost = 0.05;
  const std::vector<double> drawn = charge_drawn_ah(log, options.hold);
  CountedSoc out;
  Eigen::VectorXd& soc = out.soc;
  soc = (column(drawn).array() - drawn[options.anchor.row]) * (-1.0 / options.capacity_ah) + options.anchor.soc;
  auto from = static_cast<Index>(options.anchor.row);
  for (const std::size_t full : options.full_rows) {
    if (full <= options.anchor.row) continue;
    const auto row = static_cast<Index>(full);
    const double missing = 1.0 - soc(row);
    Index lowest = 0;
    soc.segment(from, row - from + 1).minCoeff(&lowest);
    lowest += from;
    const double put_back = soc(row) - soc(lowest);
    for (Index at = lowest; at < row && put_back > 0.0; ++at)
      soc(at) += missing * std::clamp((soc(at) - soc(lowest)) / put_back, 0.0, 1.0);
    if (std::abs(missing) > kLost) out.unknown.emplace_back(lowest, row - 1);
    soc.tail(soc.size() - row).array() += missing;
    from = row;
  }
  return out;
}

/// Lengths, currents and weights of the intervals; where branch states are free.
void set_intervals(const CellLog& log, const RunOptions& options, MeasuredRun& run) {
  const Index n = run.rows();
  run.dt_s = run.current_begin_a = run.current_end_a = run.weight_s = Eigen::VectorXd::Zero(n);
  run.reset.assign(log.rows(), false);
  run.at_rest_before.assign(log.rows(), false);
  run.reset[0] = true;
  run.at_rest_before[0] = resting_rows(log)[0] || options.anchor.row == 0;
  for (Index row = 1; row < n; ++row) {
    const auto at = static_cast<std::size_t>(row);
    run.dt_s(row) = log.time_s[at] - log.time_s[at - 1];
    run.current_begin_a(row) = options.hold == CurrentHold::kNext ? log.current_a[at] : log.current_a[at - 1];
    run.current_end_a(row) = options.hold == CurrentHold::kPrevious ? log.current_a[at - 1] : log.current_a[at];
    run.reset[at] = log.gap[at];
    const double share = log.gap[at] ? 0.0 : 0.5 * std::min(run.dt_s(row), 2.0 * options.weight_cap_s);
    run.weight_s(row) += share;
    run.weight_s(row - 1) += share;
  }
}

/// Rows whose voltage is none, or not that of their current, lose their weight.
void drop_unusable_rows(const CellLog& log, CurrentHold hold, MeasuredRun& run) {
  const double most = largest_current(log);
  for (Index row = 0; row < run.rows(); ++row) {
    if (hold == CurrentHold::kLinear && has_step_inside(log, static_cast<std::size_t>(row), most))
      run.weight_s(row) = 0.0;
    if (!std::isfinite(run.voltage_v(row))) run.weight_s(row) = run.voltage_v(row) = 0.0;
  }
}

/// The recorded one, the last before a row that has none, the first before them all.
Eigen::VectorXd temperature_of(const CellLog& log, double otherwise_c) {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(static_cast<Index>(log.rows()), otherwise_c);
  const auto known = [](double t) { return std::isfinite(t); };
  const auto first = std::find_if(log.temperature_c.begin(), log.temperature_c.end(), known);
  if (first == log.temperature_c.end()) return out;
  double last = *first;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (known(log.temperature_c[row])) last = log.temperature_c[row];
    out(static_cast<Index>(row)) = last;
  }
  return out;
}

}  // namespace

MeasuredRun make_run(const CellLog& log, const RunOptions& options) {
  VOLTLAP_DEMAND(log.rows() > 0 && log.current_a.size() == log.rows() && log.voltage_v.size() == log.rows());
  VOLTLAP_DEMAND(log.temperature_c.empty() || log.temperature_c.size() == log.rows());
  VOLTLAP_DEMAND(log.gap.size() == log.rows() && options.anchor.row < log.rows());
  VOLTLAP_DEMAND(increasing(log.time_s) && all_finite(log.current_a));
  MeasuredRun run;
  run.name = log.path;
  run.time_s = column(log.time_s);
  run.current_a = column(log.current_a);
  run.voltage_v = column(log.voltage_v);
  CountedSoc counted = counted_soc(log, options);
  run.soc = std::move(counted.soc);
  set_intervals(log, options, run);
  for (const auto& [first, last] : counted.unknown) run.weight_s.segment(first, last - first + 1).setZero();
  drop_unusable_rows(log, options.hold, run);
  run.temperature_c = temperature_of(log, options.temperature_c);
  return run;
}

namespace {

/// Rows that may be taken together: the current is the same before and after them, and nothing begins or jumps there.
std::vector<bool> steady_rows(const MeasuredRun& run) {
  constexpr double kSame = 0.01, kJump = 0.02;  // of the largest current; V: a glitch stays by itself
  const double most = run.current_a.cwiseAbs().maxCoeff();
  std::vector<bool> out(static_cast<std::size_t>(run.rows()), false);
  for (Index row = 1; row + 1 < run.rows(); ++row) {
    const auto same = [&](Index other) {
      const bool at_row = std::abs(run.current_a(other) - run.current_a(row)) <= kSame * most;
      const bool between = std::abs(run.current_begin_a(std::max(row, other)) - run.current_a(row)) <= kSame * most &&
                           std::abs(run.current_end_a(std::max(row, other)) - run.current_a(row)) <= kSame * most;
      return at_row && between && run.weight_s(other) > 0.0 &&
             std::abs(run.voltage_v(other) - run.voltage_v(row)) < kJump;
    };
    out[static_cast<std::size_t>(row)] =
        run.weight_s(row) > 0.0 && !run.is_reset(row) && !run.is_reset(row + 1) && same(row - 1) && same(row + 1);
  }
  return out;
}

/// One row for rows first to last (exclusive): means over their weights.
void add_mean(const MeasuredRun& run, Index first, Index last, Index out_row, MeasuredRun& out) {
  const auto weights = run.weight_s.segment(first, last - first);
  const double sum = weights.sum();
  out.weight_s(out_row) = sum;
  for (auto member : {&MeasuredRun::time_s, &MeasuredRun::current_a, &MeasuredRun::voltage_v, &MeasuredRun::soc,
                      &MeasuredRun::temperature_c}) {
    (out.*member)(out_row) =
        last - first == 1 ? (run.*member)(first) : (run.*member).segment(first, last - first).dot(weights) / sum;
  }
  const auto before = static_cast<std::size_t>(first);
  out.reset.push_back(run.reset[before]);
  out.at_rest_before.push_back(run.at_rest_before[before]);
}

}  // namespace

namespace {

/// One row for the rows from each begin to the next.
MeasuredRun means_of(const MeasuredRun& run, const std::vector<Index>& begins) {
  MeasuredRun out;
  out.name = run.name;
  const auto n = static_cast<Index>(begins.size());
  for (auto member : {&MeasuredRun::time_s, &MeasuredRun::current_a, &MeasuredRun::voltage_v, &MeasuredRun::soc,
                      &MeasuredRun::dt_s, &MeasuredRun::current_begin_a, &MeasuredRun::current_end_a,
                      &MeasuredRun::weight_s, &MeasuredRun::temperature_c})
    (out.*member) = Eigen::VectorXd::Zero(n);
  for (Index k = 0; k < n; ++k) {
    const Index first = begins[static_cast<std::size_t>(k)],
                last = k + 1 < n ? begins[static_cast<std::size_t>(k) + 1] : run.rows();
    add_mean(run, first, last, k, out);
    if (k == 0) continue;
    out.dt_s(k) = out.time_s(k) - out.time_s(k - 1);
    const bool neighbours = last - first == 1 && first - begins[static_cast<std::size_t>(k) - 1] == 1;
    out.current_begin_a(k) = neighbours ? run.current_begin_a(first) : out.current_a(k - 1);
    out.current_end_a(k) = neighbours ? run.current_end_a(first) : out.current_a(k);
  }
  return out;
}

}  // namespace

MeasuredRun averaged(const MeasuredRun& run, double share) {
  constexpr double kSocMost = 0.004;
  VOLTLAP_DEMAND(run.rows() > 0 && share >= 0.0);
  const std::vector<bool> steady = steady_rows(run);
  std::vector<Index> begins{0};
  double step_at = run.time_s(0);
  for (Index row = 1; row < run.rows(); ++row) {
    const auto at = static_cast<std::size_t>(row);
    if (!steady[at]) step_at = run.time_s(row);
    const Index first = begins.back();
    const bool together = steady[at] && steady[static_cast<std::size_t>(first)] &&
                          run.time_s(row) - run.time_s(first) < share * (run.time_s(row) - step_at) &&
                          std::abs(run.soc(row) - run.soc(first)) < kSocMost;
    if (!together) begins.push_back(row);
  }
  return means_of(run, begins);
}

MeasuredRun coarsened(const MeasuredRun& run, double seconds) {
  VOLTLAP_DEMAND(run.rows() > 0 && seconds > 0.0);
  std::vector<Index> begins{0};
  for (Index row = 1; row < run.rows(); ++row) {
    const Index first = begins.back();
    const bool together = first > 0 && run.time_s(row) - run.time_s(first) < seconds && !run.is_reset(row) &&
                          run.weight_s(row) > 0.0 && run.weight_s(first) > 0.0;
    if (!together) begins.push_back(row);
  }
  return means_of(run, begins);
}

std::vector<MeasuredRun> coarsened_where_many(const std::vector<MeasuredRun>& runs) {
  constexpr Index kMany = 30000;
  constexpr double kSeconds = 1.0;
  Index rows = 0;
  for (const MeasuredRun& run : runs) rows += run.rows();
  if (rows <= kMany) return runs;
  std::vector<MeasuredRun> out;
  for (const MeasuredRun& run : runs) out.push_back(coarsened(run, kSeconds));
  VOLTLAP_DEMAND(out.size() == runs.size());
  return out;
}

namespace {

/// Rows that thinned() keeps: all under load, and of a rest one whenever `share` of its time has passed.
std::vector<Index> rows_kept(const MeasuredRun& run, double share) {
  std::vector<Index> keep{0};
  double step_at = run.time_s(0);
  const double quiet = kRestShare * run.current_a.cwiseAbs().maxCoeff();
  for (Index row = 1; row < run.rows(); ++row) {
    const auto resting = [&](Index at) {
      return std::abs(run.current_begin_a(at)) <= quiet && std::abs(run.current_end_a(at)) <= quiet &&
             std::abs(run.current_a(at)) <= quiet;
    };
    const bool still =
        resting(row) && row + 1 < run.rows() && resting(row + 1) && !run.is_reset(row) && !run.is_reset(row + 1);
    if (!resting(row)) step_at = run.time_s(row);
    if (!still || run.time_s(row) - run.time_s(keep.back()) >= share * (run.time_s(row) - step_at))
      keep.push_back(row);
  }
  return keep;
}

}  // namespace

MeasuredRun thinned(const MeasuredRun& run, double share) {
  VOLTLAP_DEMAND(run.rows() > 0 && share >= 0.0);
  const std::vector<Index> keep = rows_kept(run, share);
  MeasuredRun out;
  out.name = run.name;
  const auto n = static_cast<Index>(keep.size());
  for (auto member : {&MeasuredRun::time_s, &MeasuredRun::current_a, &MeasuredRun::voltage_v, &MeasuredRun::soc,
                      &MeasuredRun::current_begin_a, &MeasuredRun::current_end_a, &MeasuredRun::temperature_c}) {
    (out.*member).resize(n);
    for (Index k = 0; k < n; ++k) (out.*member)(k) = (run.*member)(keep[static_cast<std::size_t>(k)]);
  }
  out.dt_s = out.weight_s = Eigen::VectorXd::Zero(n);
  for (Index k = 0, from = 0; k < n; ++k) {
    const Index row = keep[static_cast<std::size_t>(k)];
    if (k > 0) out.dt_s(k) = out.time_s(k) - out.time_s(k - 1);
    out.weight_s(k) = run.weight_s.segment(from, row + 1 - from).sum();
    if (run.weight_s(row) == 0.0) out.weight_s(k) = 0.0;
    from = row + 1;
    out.reset.push_back(run.is_reset(row));
    out.at_rest_before.push_back(run.at_rest_before[static_cast<std::size_t>(row)]);
  }
  return out;
}

}  // namespace voltlap::plant
