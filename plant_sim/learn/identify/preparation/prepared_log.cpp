// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/prepared_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/errors.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

void require_excitation(const CellLog& log) {
  const auto [low, high] = std::minmax_element(log.current_a.begin(), log.current_a.end());
  if (*high == 0.0 && *low == 0.0) {
    throw InputError(log.path, "no current in any row", "pulses or a drive",
                     "Check the current's column in the role map");
  }
  if (*high - *low < 1e-3 * std::max(std::abs(*high), std::abs(*low))) {
    throw InputError(log.path, fmt::format("a current of {:.4g} A that never changes", *high),
                     "pulses and rests, or a drive",
                     "Resistances need a current that changes: give another recording");
  }
}

/// How well a plain circuit follows the rows at which the current has just jumped, weighted by time: there the
/// holds differ most, since a wrong one puts a wrong charge and a wrong relaxation into the interval.
double error_at_jumps(const CellLog& log, const RunOptions& options) {
  constexpr double kJump = 0.05;
  std::vector<MeasuredRun> runs{averaged(make_run(log, options))};
  FitPriors priors;
  priors.smoothness = 1.0;
  const auto steps = resistance_steps(runs[0]);
  priors.resistance_scale =
      steps.empty() ? 0.05 / runs[0].current_a.cwiseAbs().maxCoeff() : steps[steps.size() / 2].resistance_ohm;
  const CircuitFit fit(runs, 2, priors);
  const Eigen::MatrixXd tau = Eigen::RowVector2d(20.0, 500.0).replicate(fit.r_count(), 1);
  const LinearSolution solution = fit.solve(tau);
  const Eigen::VectorXd error =
      simulate(fit.model_of(solution, tau), runs[0], solution.x.tail(fit.state_count())) - runs[0].voltage_v;
  const double most = runs[0].current_a.cwiseAbs().maxCoeff();
  double sum = 0.0, weight = 1e-12;
  for (Index row = 1; row < runs[0].rows(); ++row) {
    if (std::abs(runs[0].current_a(row) - runs[0].current_a(row - 1)) < kJump * most) continue;
    sum += runs[0].weight_s(row) * error(row) * error(row);
    weight += runs[0].weight_s(row);
  }
  return sum / weight;
}

void choose_hold(PreparedLog& one, const std::vector<PreparedLog>& before, const PriorKnowledge& known) {
  if (known.hold) {
    one.run.hold = *known.hold;
    one.hold_from = "the command";
    return;
  }
  const auto counted = hold_from_counter(*one.log);
  if (!counted.empty()) {
    one.run.hold = counted[0].hold;
    one.hold_from = "its counter";
    return;
  }
  if (!one.anchored && !before.empty()) {
    one.run.hold = before[0].run.hold;
    one.hold_from = "like the first file";
    one.hold_certain = before[0].hold_certain;
    return;
  }
  constexpr double kClearly = 0.9;  // on a regular grid the candidates hardly differ
  double least = 1e300, most = 0.0;
  for (const CurrentHold hold : {CurrentHold::kNext, CurrentHold::kPrevious, CurrentHold::kLinear}) {
    RunOptions tried = one.run;
    tried.hold = hold;
    if (!known.capacity_ah) tried.capacity_ah = std::max(1e-3, span_ah(*one.log, tried.anchor.row, hold));
    const double error = error_at_jumps(*one.log, tried);
    most = std::max(most, error);
    if (error < kClearly * least) {
      least = error;
      one.run.hold = hold;
    }
  }
  one.hold_certain = least < kClearly * most;
  one.hold_from = one.hold_certain ? "its voltage" : "habit: its voltage does not tell";
}

double settled_capacity(double spanned, const PriorKnowledge& known, std::vector<std::string>& notes) {
  constexpr double kWhole = 0.9;
  if (known.capacity_ah) {
    notes.push_back(
        fmt::format("Capacity {:.3f} Ah, as known; these recordings span {:.3f} Ah.", *known.capacity_ah, spanned));
    return *known.capacity_ah;
  }
  if (known.capacity_fallback_ah && spanned < kWhole * *known.capacity_fallback_ah) {
    notes.push_back(fmt::format("The recordings span {:.3f} Ah; the capacity of {:.3f} Ah is the given cell's.",
                                spanned, *known.capacity_fallback_ah));
    return *known.capacity_fallback_ah;
  }
  notes.push_back(
      fmt::format("Capacity {:.3f} Ah: what the longest discharge draws after SOC 1; SOC 0 is its end.", spanned));
  return spanned;
}

/// One pulse from rest to rest tells a resistance, but neither a capacity nor an OCV over SOC.
void require_more_than_one_pulse(const std::vector<CellLog>& logs) {
  constexpr double kDrawn = 0.05, kOneCurrent = 0.35, kWholeDischarge = 0.3;  // of the largest; relative; V
  if (logs.size() != 1) return;
  const CellLog& log = logs.front();
  const double most = *std::max_element(log.current_a.begin(), log.current_a.end());
  std::size_t pulses = 0, first = 0, last = 0;
  double least = most;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (log.current_a[row] < -kDrawn * most) return;
    if (log.current_a[row] <= kDrawn * most) continue;
    if (pulses == 0) first = row;
    if (pulses == 0 || last + 1 != row) ++pulses;
    last = row;
    least = std::min(least, log.current_a[row]);
  }
  const double before = log.voltage_v[first > 0 ? first - 1 : 0], after = log.voltage_v.back();
  const bool rests = first > 0 && last + 1 < log.rows(), one_current = most - least < kOneCurrent * most;
  if (pulses != 1 || !rests || !one_current || !(before - after < kWholeDischarge)) return;
  throw InputError(log.path, fmt::format("one pulse, from {:.3f} to {:.3f} V at rest", before, after),
                   "several pulses or a whole discharge: one pulse tells neither capacity nor OCV",
                   "Give them too, or a cell file of the same type with --ocv");
}

}  // namespace

double span_ah(const CellLog& log, std::size_t from, CurrentHold hold) {
  const std::vector<double> drawn = charge_drawn_ah(log, hold);
  return *std::max_element(drawn.begin() + static_cast<std::ptrdiff_t>(from), drawn.end()) - drawn[from];
}

std::vector<PreparedLog> prepare(const std::vector<CellLog>& logs, const PriorKnowledge& known,
                                 std::vector<std::string>& notes) {
  std::vector<PreparedLog> out;
  double capacity = 0.0;
  if (!known.capacity_ah && !known.capacity_fallback_ah) require_more_than_one_pulse(logs);
  for (const CellLog& log : logs) {
    require_excitation(log);
    PreparedLog one{&log, {}, {}};
    one.run.per_kelvin = known.per_kelvin;
    one.run.reference_temperature_c = known.reference_temperature_c;
    const auto full = full_charges(log);
    one.anchored = !full.empty();
    if (one.anchored) one.run.anchor = {full.back(), 1.0, "full charge"};
    one.run.full_rows = full;
    if (known.capacity_ah) one.run.capacity_ah = *known.capacity_ah;
    choose_hold(one, out, known);
    // A full charge at the end of a recording spans nothing: then the one before which most was drawn.
    if (one.anchored) {
      double most = -1.0;
      for (const std::size_t row : full) {
        const double span = span_ah(log, row, one.run.hold);
        if (span <= most) continue;
        most = span;
        one.run.anchor.row = row;
      }
      capacity = std::max(capacity, most);
    }
    out.push_back(std::move(one));
  }
  if (capacity == 0.0) {
    PreparedLog& first = out.front();
    first.anchored = true;
    const std::vector<double> drawn = charge_drawn_ah(*first.log, first.run.hold);
    const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
    first.run.anchor = {static_cast<std::size_t>(low - drawn.begin()), 1.0, "assumed"};
    capacity = *high - *low;
    notes.push_back("No full charge in the recordings: SOC 1 is assumed at the least charge drawn.");
  }
  capacity = settled_capacity(capacity, known, notes);
  for (PreparedLog& one : out) one.run.capacity_ah = capacity;
  return out;
}

void anchor_by_model(std::vector<PreparedLog>& prepared, const CircuitModel& model, double shortest_rest_s) {
  for (PreparedLog& one : prepared) {
    if (one.anchored) continue;
    one.anchored = true;
    one.run.anchor = {0, 0.5, "fitted"};
    const MeasuredRun run = make_run(*one.log, one.run);
    const auto soc_at = [&](double voltage) {
      double low = 0.0, high = 1.0;
      for (int k = 0; k < 40; ++k)
        (model.ocv.value(model.em, 0.5 * (low + high)) < voltage ? low : high) = 0.5 * (low + high);
      return 0.5 * (low + high);
    };
    const auto rests = ocv_from_rests(run, shortest_rest_s);
    if (!rests.empty()) {
      // The rest's SOC was counted from 0.5 at row 0.
      one.run.anchor = {0, 0.5 + soc_at(rests.front().voltage_v) - rests.front().soc, "rest"};
      continue;
    }
    double best = 1e300;
    const auto error_at = [&](double soc) {
      RunOptions tried = one.run;
      tried.anchor.soc = soc;
      const MeasuredRun at = make_run(*one.log, tried);
      const Eigen::VectorXd e = simulate(model, at) - at.voltage_v;
      return (at.weight_s.array() * e.array().square()).sum();
    };
    double centre = 0.5;
    for (double width = 0.5; width > 5e-4; width *= 0.25) {
      const double from = centre;
      for (int k = -4; k <= 4; ++k) {
        const double soc = from + width * k / 4.0, error = error_at(soc);
        if (error < best) {
          best = error;
          centre = soc;
        }
      }
    }
    one.run.anchor.soc = centre;
  }
}

std::vector<MeasuredRun> runs_of(const std::vector<PreparedLog>& prepared, bool every_row) {
  std::vector<MeasuredRun> runs;
  for (const PreparedLog& one : prepared) {
    if (!one.anchored) continue;
    const MeasuredRun run = make_run(*one.log, one.run);
    runs.push_back(every_row ? run : averaged(run));
  }
  return runs;
}

std::vector<HysteresisPoint> hysteresis_of(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kSlow = 1.0 / 8.0, kSteady = 300.0, kBin = 0.05;  // C-rate; s; SOC
  struct Side {
    double weight = 0.0, voltage = 0.0, current = 0.0;
  };
  std::map<int, std::array<Side, 2>> bins;
  std::vector<double> resistances;
  for (const MeasuredRun& run : runs) {
    for (const StepEstimate& step : resistance_steps(run)) resistances.push_back(step.resistance_ohm);
    double steady = 0.0;
    for (Index row = 1; row < run.rows(); ++row) {
      const double i = run.current_a(row);
      const bool slow = std::abs(i) < kSlow * capacity_ah && std::abs(i) > 1e-3 * capacity_ah;
      steady = slow && i * run.current_a(row - 1) > 0.0 ? steady + run.dt_s(row) : 0.0;
      if (steady < kSteady || run.weight_s(row) <= 0.0) continue;
      Side& side = bins[static_cast<int>(std::floor(run.soc(row) / kBin))][i > 0.0 ? 0 : 1];
      side.weight += run.weight_s(row);
      side.voltage += run.weight_s(row) * run.voltage_v(row);
      side.current += run.weight_s(row) * std::abs(i);
    }
  }
  // Both branches add about as much again as the step shows, each.
  constexpr double kWhole = 3.0;
  double resistance = 0.0;
  if (!resistances.empty()) {
    std::nth_element(resistances.begin(), resistances.begin() + static_cast<std::ptrdiff_t>(resistances.size() / 2),
                     resistances.end());
    resistance = kWhole * resistances[resistances.size() / 2];
  }
  std::vector<HysteresisPoint> out;
  for (const auto& [bin, sides] : bins) {
    if (bin < 2 || bin > 17 || sides[0].weight <= 0.0 || sides[1].weight <= 0.0)
      continue;  // ends: the OCV is too steep
    const double down = sides[0].voltage / sides[0].weight, up = sides[1].voltage / sides[1].weight;
    const double current = 0.5 * (sides[0].current / sides[0].weight + sides[1].current / sides[1].weight);
    const double half = 0.5 * (up - down);
    out.push_back({kBin * (bin + 0.5), 0.5 * (up + down), half, half - current * resistance});
  }
  return out;
}

}  // namespace voltlap::plant
