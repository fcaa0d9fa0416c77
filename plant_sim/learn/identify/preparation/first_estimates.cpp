// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/first_estimates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {

using Eigen::Index;

double quiet_current(const MeasuredRun& run) {
  constexpr double kShare = 0.01, kMost = 0.05, kSigmas = 4.0;
  constexpr double kTail = 0.9, kTailOfSigma = 1.645 * 1.4142;  // of the difference of two rows
  const double most = run.current_a.cwiseAbs().maxCoeff();
  std::vector<double> steps;
  for (Index row = 1; row < run.rows(); ++row) {
    const double before = run.current_a(row - 1), now = run.current_a(row);
    if (!run.is_reset(row) && std::max(std::abs(before), std::abs(now)) <= kMost * most)
      steps.push_back(std::abs(now - before));
  }
  const double sigma = steps.empty() ? 0.0 : quantile(std::move(steps), kTail) / kTailOfSigma;
  return std::clamp(kSigmas * sigma, kShare * most, kMost * most);
}

std::vector<PulseSegment> segments(const MeasuredRun& run) {
  const double quiet = quiet_current(run);
  const auto kind_of = [&](double i) {
    return std::abs(i) <= quiet ? PulseSegment::Kind::kRest
           : i > 0.0            ? PulseSegment::Kind::kDischarge
                                : PulseSegment::Kind::kCharge;
  };
  std::vector<PulseSegment> out;
  for (Index row = 0; row < run.rows(); ++row) {
    const auto kind = kind_of(run.current_a(row));
    if (out.empty() || out.back().kind != kind || run.is_reset(row)) out.push_back({kind, row, row, 0.0});
    out.back().last = row + 1;
    if (row > out.back().first) out.back().duration_s += run.dt_s(row);
  }
  return out;
}

namespace {

constexpr double kJump = 0.1;  // of the largest current

/// Within which a change of the current is a step [s]: two seconds, or the interval of a slower recorder.
double longest_step(const MeasuredRun& run) {
  constexpr double kShort = 2.0, kLong = 60.0, kInterval = 1.5;
  std::vector<double> intervals;
  for (Index row = 1; row < run.rows(); ++row) {
    if (!run.is_reset(row)) intervals.push_back(run.dt_s(row));
  }
  return intervals.empty() ? kShort : std::clamp(kInterval * median(std::move(intervals)), kShort, kLong);
}

/// From one row to a later one; none where the voltage goes with the current.
void add_step(const MeasuredRun& run, Index from, Index to, std::vector<StepEstimate>& out) {
  const double r = -(run.voltage_v(to) - run.voltage_v(from)) / (run.current_a(to) - run.current_a(from));
  if (r > 0.0) out.push_back({run.soc(to), r});
}

/// Where the current jumps between two rows.
std::vector<StepEstimate> sharp_steps(const MeasuredRun& run, double least_a, double longest_s) {
  std::vector<StepEstimate> out;
  for (Index row = 1; row < run.rows(); ++row) {
    const double di = run.current_a(row) - run.current_a(row - 1);
    const bool usable = run.weight_s(row) > 0.0 && run.weight_s(row - 1) > 0.0 && !run.is_reset(row);
    if (usable && run.dt_s(row) <= longest_s && std::abs(di) >= least_a) add_step(run, row - 1, row, out);
  }
  return out;
}

/// Where the current goes as far within two seconds or so, over any number of rows, of which some may have no voltage:
/// a pedal takes half a second, and on a bus current and voltage come in turn. Steps do not overlap.
std::vector<StepEstimate> gradual_steps(const MeasuredRun& run, double least_a, double longest_s) {
  std::vector<StepEstimate> out;
  Index begin = 0;
  for (Index row = 0; row < run.rows(); ++row) {
    if (run.is_reset(row)) begin = row;
    if (run.weight_s(row) <= 0.0) continue;
    Index from = row;
    double most = 0.0;
    for (Index k = row - 1; k >= begin && run.time_s(row) - run.time_s(k) <= longest_s; --k) {
      const double change = std::abs(run.current_a(row) - run.current_a(k));
      if (run.weight_s(k) <= 0.0 || change <= most) continue;
      most = change;
      from = k;
    }
    if (from == row || most < least_a) continue;
    add_step(run, from, row, out);
    begin = row;
  }
  return out;
}

}  // namespace

std::vector<StepEstimate> resistance_steps(const MeasuredRun& run) {
  constexpr std::size_t kEnough = 3;  // a change over seconds has polarization in it, and at an empty cell a slope
  const double least_a = kJump * run.current_a.cwiseAbs().maxCoeff();
  const double longest_s = longest_step(run);
  std::vector<StepEstimate> sharp = sharp_steps(run, least_a, longest_s);
  return sharp.size() >= kEnough || least_a <= 0.0 ? sharp : gradual_steps(run, least_a, longest_s);
}

std::size_t step_count(const std::vector<MeasuredRun>& runs) {
  std::size_t out = 0;
  for (const MeasuredRun& run : runs) out += resistance_steps(run).size();
  return out;
}

double resistance_step_median(const std::vector<MeasuredRun>& runs) {
  std::vector<double> resistances;
  for (const MeasuredRun& run : runs) {
    for (const StepEstimate& step : resistance_steps(run)) resistances.push_back(step.resistance_ohm);
  }
  return median(std::move(resistances));
}

std::vector<OcvKnowledge> ocv_from_rests(const MeasuredRun& run, double shortest_s) {
  constexpr double kLeastSigma = 5e-4;
  std::vector<OcvKnowledge> out;
  for (const PulseSegment& s : segments(run)) {
    if (s.kind != PulseSegment::Kind::kRest || s.duration_s < shortest_s || run.weight_s(s.last - 1) <= 0.0) continue;
    const double end = run.time_s(s.last - 1);
    // Voltages at a half and a quarter of the rest before its end tell how fast it still moves.
    const auto voltage_at = [&](double t) {
      const double* first = run.time_s.data() + s.first;
      const auto at = std::lower_bound(first, run.time_s.data() + s.last - 1, t) - run.time_s.data();
      return run.voltage_v(at);
    };
    const double v3 = run.voltage_v(s.last - 1), v2 = voltage_at(end - 0.25 * s.duration_s),
                 v1 = voltage_at(end - 0.5 * s.duration_s);
    const double late = v3 - v2, early = v2 - v1;
    const double ratio = std::abs(early) > 1e-4 ? std::clamp(late / early, 0.0, 0.8) : 0.0;
    const double still_to_go = late * ratio / (1.0 - ratio);
    out.push_back({run.soc(s.last - 1), v3 + still_to_go,
                   std::max(kLeastSigma, std::abs(still_to_go) + 0.5 * std::abs(late)), run.temperature_c(s.last - 1)});
  }
  return out;
}

namespace {

constexpr int kSlowBins = 40;  // of SOC

/// Sums over the rows around a node of SOC in which the current went one way.
struct Side {
  double voltage = 0.0, weight = 0.0;
};
using SlowBins = std::array<std::array<Side, 2>, kSlowBins + 1>;  // discharge, charge

/// Hat weights: the mean voltage around a node, straight within its bin.
SlowBins slow_bins(const MeasuredRun& run, double capacity_ah) {
  constexpr double kSlow = 0.1;  // C-rate
  SlowBins bins{};
  for (Index row = 0; row < run.rows(); ++row) {
    const double i = run.current_a(row), soc = run.soc(row);
    if (std::abs(i) > kSlow * capacity_ah || std::abs(i) < 1e-3 * capacity_ah || soc < 0.0 || soc > 1.0) continue;
    const auto bin = static_cast<std::size_t>(std::lround(soc * kSlowBins));
    const double weight =
        run.weight_s(row) * std::max(0.0, 1.0 - 2.0 * std::abs(soc * kSlowBins - static_cast<double>(bin)));
    Side& side = bins[bin][i > 0.0 ? 0 : 1];
    side.voltage += weight * run.voltage_v(row);
    side.weight += weight;
  }
  return bins;
}

std::vector<OcvKnowledge> middle_of(const SlowBins& bins) {
  constexpr double kOneSided = 0.01, kLeastSigma = 1e-3;  // V
  std::vector<OcvKnowledge> out;
  for (std::size_t bin = 0; bin < bins.size(); ++bin) {
    const auto& [down, up] = bins[bin];
    const double soc = static_cast<double>(bin) / kSlowBins;
    if (down.weight <= 0.0) continue;
    const double low = down.voltage / down.weight;
    if (up.weight <= 0.0) {
      out.push_back({soc, low, kOneSided});
    } else {
      const double high = up.voltage / up.weight;
      out.push_back({soc, 0.5 * (low + high), std::max(kLeastSigma, 0.5 * std::abs(high - low))});
    }
  }
  return out;
}

}  // namespace

SlowTest ocv_from_slow_test(const CellLog& log) {
  VOLTLAP_DEMAND(log.rows() > 0 && log.current_a.size() == log.rows());
  RunOptions options;
  const auto full = full_charges(log);
  const std::vector<double> drawn = charge_drawn_ah(log, options.hold);
  const std::size_t from = full.empty() ? 0 : full.front();
  SlowTest out;
  out.capacity_ah = *std::max_element(drawn.begin() + static_cast<std::ptrdiff_t>(from), drawn.end()) - drawn[from];
  options.capacity_ah = std::max(out.capacity_ah, 1e-6);
  options.anchor.row = from;
  out.ocv = middle_of(slow_bins(make_run(log, options), out.capacity_ah));
  if (out.ocv.size() < 10) {
    throw InputError(log.path, "no slow discharge over the range of SOC",
                     "a discharge at C/10 or slower from a full charge",
                     "Give a slow test or a cell file with --ocv");
  }
  return out;
}

}  // namespace voltlap::plant
