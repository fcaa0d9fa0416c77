// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/prepared_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
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
    if (!known.capacity_ah) tried.capacity_ah = std::max(1e-3, counted_ah(*one.log, tried.anchor.row, hold));
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

PreparedLog anchored_where_full(const CellLog& log, const PriorKnowledge& known) {
  PreparedLog one{&log, {}, {}};
  one.run.full_rows = possible_full_rows(log);
  one.anchored = !one.run.full_rows.empty();
  if (one.anchored) one.run.anchor = {one.run.full_rows.back(), 1.0, "full charge"};
  if (known.capacity_ah) one.run.capacity_ah = *known.capacity_ah;
  return one;
}

/// A full charge at the end of a recording spans nothing: then the one before which most was drawn. Returns what it
/// spans [Ah].
double anchor_before_longest(PreparedLog& one) {
  double most = -1.0;
  for (const std::size_t row : one.run.full_rows) {
    const double span = span_ah(*one.log, row, one.run.hold);
    if (span <= most) continue;
    most = span;
    one.run.anchor.row = row;
  }
  return most;
}

/// Without any full charge. Returns what the recording spans [Ah].
double assume_full_at_least_drawn(PreparedLog& first) {
  first.anchored = true;
  const std::vector<double> drawn = charge_drawn_ah(*first.log, first.run.hold);
  const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
  first.run.anchor = {static_cast<std::size_t>(low - drawn.begin()), 1.0, "assumed"};
  return *high - *low;
}

/// A recording that begins at its own highest voltage need not begin full: others of the cell may stand higher.
void doubt_full(std::vector<PreparedLog>& prepared) {
  constexpr double kLower_v = 0.05;
  const auto is_full = [](const PreparedLog& one) {
    return one.anchored && (one.run.anchor.from == "full charge" || one.run.anchor.from == "assumed");
  };
  double highest = 0.0;
  for (const PreparedLog& one : prepared) {
    if (is_full(one)) highest = std::max(highest, one.log->voltage_v[one.run.anchor.row]);
  }
  for (PreparedLog& one : prepared) {
    if (!is_full(one) || one.run.full_rows.size() > 1) continue;
    if (one.log->voltage_v[one.run.anchor.row] > highest - kLower_v) continue;
    one.full_in_doubt = one.run.anchor;
    one.run.full_rows.clear();
    one.anchored = false;
  }
}

/// The charge after SOC 1, or that which was put back before it, and whether it is all that the cell holds.
Capacity spanned_capacity(PreparedLog& one) {
  constexpr double kLoss = 0.95;  // what is put back is more than what is drawn after
  const double drawn = anchor_before_longest(one), back = put_back_ah(*one.log, one.run.anchor.row, one.run.hold);
  const bool by_charge = drawn < kLoss * back;
  const RecordedEnds ends = recorded_ends(*one.log, one.run);
  if (!ends.full) one.run.anchor.from = "assumed";
  if (!ends.full || !ends.empty) return {by_charge ? back : drawn, CapacityFrom::kDrawnOnly};
  return {by_charge ? back : drawn, by_charge ? CapacityFrom::kWholeCharge : CapacityFrom::kWholeDischarge};
}

/// A known capacity that the recordings contradict would put their SOC anywhere. `moved_ah`: most in one of them, that
/// of `path`.
void require_possible_capacity(double known_ah, const Capacity& spanned, double moved_ah, const std::string& path) {
  // A counter drifts over weeks of cycles; a fast discharge in the cold ends long before the cell is empty.
  constexpr double kDrift = 1.3, kEndsEarly = 2.5;
  constexpr const char* kWayOut =
      "Correct --capacity (of one cell), --cells-in-parallel or the unit of the current; without --capacity it is that "
      "of the recordings nearest to 25 degC, which may have drawn only a part";
  if (moved_ah > kDrift * known_ah) {
    throw InputError(path, fmt::format("{:.4g} Ah between its fullest and its emptiest moment", moved_ah),
                     fmt::format("at most the {:.4g} Ah of the cell", known_ah), kWayOut);
  }
  if (spanned.is_lower_bound() || known_ah <= kEndsEarly * spanned.ah) return;
  throw InputError(path, fmt::format("{:.4g} Ah from a full to an empty cell", spanned.ah),
                   fmt::format("not so little of the {:.4g} Ah of the cell", known_ah), kWayOut);
}

/// What is known of the capacity before what a part of a discharge has drawn.
Capacity settled_capacity(const Capacity& spanned, const std::vector<PreparedLog>& prepared,
                          const PriorKnowledge& known) {
  constexpr double kWhole = 0.9, kNarrow = 0.1;
  if (known.capacity_ah) return {*known.capacity_ah, CapacityFrom::kTold};
  const bool like_given = known.capacity_fallback_ah && spanned.ah >= kWhole * *known.capacity_fallback_ah;
  if (like_given && spanned.is_lower_bound()) return {spanned.ah, CapacityFrom::kWholeDischarge};
  if (like_given || !spanned.is_lower_bound()) {
    if (like_given || !known.capacity_fallback_ah) return spanned;
    return {*known.capacity_fallback_ah, CapacityFrom::kGivenCell};
  }
  std::optional<Capacity> best;
  for (const PreparedLog& one : prepared) {
    const auto found = capacity_of_rests(*one.log, one.run.hold, known.ocv);
    if (found && (!best || *found->capacity.ci95_ah < *best->ci95_ah)) best = found->capacity;
  }
  if (best && (!known.capacity_fallback_ah || *best->ci95_ah < kNarrow * best->ah)) return *best;
  if (known.capacity_fallback_ah) return {*known.capacity_fallback_ah, CapacityFrom::kGivenCell};
  return spanned;
}

/// Where a recording begins at rest without being charged before, and the OCV is known, that says how full it is.
void anchor_by_known_ocv(PreparedLog& one, const std::vector<OcvKnowledge>& ocv) {
  constexpr double kFull = 0.97;
  const bool charged = std::any_of(one.run.full_rows.begin(), one.run.full_rows.end(),
                                   [](std::size_t row) { return row > 0; });
  if (!one.anchored || charged || ocv.empty()) return;
  const auto soc = soc_by_first_rest(*one.log, one.run, ocv);
  if (!soc || *soc >= kFull) return;
  one.run.full_rows.clear();
  one.run.anchor = {0, *soc, "rest and OCV"};
}

double soc_of_ocv(const CircuitModel& model, double voltage_v) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 40; ++k)
    (model.ocv.value(model.em, 0.5 * (low + high)) < voltage_v ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

/// SOC at the anchor with which the model follows the recording best.
double best_predicted_soc(const PreparedLog& one, const CircuitModel& model) {
  const auto error_at = [&](double soc) {
    RunOptions tried = one.run;
    tried.anchor.soc = soc;
    const MeasuredRun run = make_run(*one.log, tried);
    const Eigen::VectorXd e = simulate(model, run) - run.voltage_v;
    return (run.weight_s.array() * e.array().square()).sum();
  };
  double best = 1e300, centre = 0.5;
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
  return centre;
}

}  // namespace

double span_ah(const CellLog& log, std::size_t from, CurrentHold hold) {
  const std::vector<double> drawn = charge_drawn_ah(log, hold);
  VOLTLAP_DEMAND(from < drawn.size());
  return *std::max_element(drawn.begin() + static_cast<std::ptrdiff_t>(from), drawn.end()) - drawn[from];
}

double put_back_ah(const CellLog& log, std::size_t to, CurrentHold hold) {
  const std::vector<double> drawn = charge_drawn_ah(log, hold);
  VOLTLAP_DEMAND(to < drawn.size());
  return *std::max_element(drawn.begin(), drawn.begin() + static_cast<std::ptrdiff_t>(to) + 1) - drawn[to];
}

double counted_ah(const CellLog& log, std::size_t anchor, CurrentHold hold) {
  return std::max(span_ah(log, anchor, hold), put_back_ah(log, anchor, hold));
}

void require_enough_rows(const std::vector<CellLog>& logs) {
  constexpr std::size_t kRows = 30;
  constexpr double kSeconds = 10.0;
  for (const CellLog& log : logs) {
    VOLTLAP_DEMAND(log.rows() > 0 && log.voltage_v.size() == log.rows());
    const auto rows = static_cast<std::size_t>(
        std::count_if(log.voltage_v.begin(), log.voltage_v.end(), [](double v) { return std::isfinite(v); }));
    const double seconds = log.time_s.back() - log.time_s.front();
    if (rows >= kRows && seconds >= kSeconds) continue;
    throw InputError(log.path, fmt::format("{} rows with a voltage over {:.4g} s", rows, seconds),
                     fmt::format("at least {} rows over {:g} s: less tells no resistance, capacity and OCV", kRows,
                                 kSeconds),
                     "Give a longer recording, of several pulses and rests or of a drive");
  }
}

std::vector<PreparedLog> prepare(const std::vector<CellLog>& logs, const PriorKnowledge& known,
                                 std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!logs.empty());
  if (!known.capacity_ah && !known.capacity_fallback_ah) require_more_than_one_pulse(logs);
  std::vector<PreparedLog> out;
  Capacity spanned;
  double moved = 0.0;
  const CellLog* most_moved = &logs.front();
  for (const CellLog& log : logs) {
    require_excitation(log);
    PreparedLog one = anchored_where_full(log, known);
    if (!known.temperatures_c.empty()) one.run.temperature_c = known.temperatures_c.at(out.size());
    choose_hold(one, out, known);
    if (one.anchored) {
      const Capacity found = spanned_capacity(one);
      if (found.ah > spanned.ah) spanned = found;
    }
    if (const double here = moved_ah(log, one.run.hold); here >= moved) {
      moved = here;
      most_moved = &log;
    }
    out.push_back(std::move(one));
  }
  doubt_full(out);
  if (spanned.ah == 0.0) spanned = {assume_full_at_least_drawn(out.front()), CapacityFrom::kDrawnOnly};
  if (known.capacity_ah) require_possible_capacity(*known.capacity_ah, spanned, moved, most_moved->path);
  const Capacity capacity = settled_capacity(spanned, out, known);
  notes.push_back(capacity_note(capacity, moved));
  for (PreparedLog& one : out) {
    one.capacity = capacity;
    one.run.capacity_ah = capacity.ah;
    anchor_by_known_ocv(one, known.ocv);
  }
  if (std::any_of(out.begin(), out.end(), [](const PreparedLog& one) { return one.run.anchor.from == "assumed"; }))
    notes.push_back("Nothing tells where the cell is full: SOC 1 is assumed at the least charge drawn.");
  VOLTLAP_DEMAND(out.size() == logs.size());
  return out;
}

void anchor_by_model(std::vector<PreparedLog>& prepared, const CircuitModel& model, double shortest_rest_s) {
  constexpr double kTrial = 0.5;  // SOC at row 0, from which that of a rest is counted
  VOLTLAP_DEMAND(model.em.size() == model.ocv.size() && model.em.allFinite());
  for (PreparedLog& one : prepared) {
    if (one.anchored) continue;
    one.anchored = true;
    one.run.anchor = {0, kTrial, "fitted"};
    const auto rests = ocv_from_rests(make_run(*one.log, one.run), shortest_rest_s);
    if (rests.empty()) {
      one.run.anchor.soc = best_predicted_soc(one, model);
    } else {
      one.run.anchor = {0, kTrial + soc_of_ocv(model, rests.front().voltage_v) - rests.front().soc, "rest"};
    }
  }
}

void settle_full_in_doubt(std::vector<PreparedLog>& prepared, const CircuitModel& model) {
  constexpr double kNearTop = 0.98, kAround = 0.03, kFlat_v = 0.2;  // SOC; SOC; V over the whole of it
  const auto is_flat = [&](double soc) {
    const double low = model.ocv.value(model.em, soc - kAround), high = model.ocv.value(model.em, soc + kAround);
    return high - low < 2.0 * kAround * kFlat_v;
  };
  for (PreparedLog& one : prepared) {
    if (!one.full_in_doubt || !one.anchored) continue;
    const auto row = static_cast<Eigen::Index>(one.full_in_doubt->row);
    const double soc = make_run(*one.log, one.run).soc(row);
    if (soc > kNearTop || is_flat(soc)) {
      one.run.anchor = *one.full_in_doubt;
      one.run.full_rows = {one.full_in_doubt->row};
    }
    one.full_in_doubt.reset();
  }
}

std::vector<MeasuredRun> runs_of(const std::vector<PreparedLog>& prepared, bool every_row) {
  std::vector<MeasuredRun> runs;
  for (const PreparedLog& one : prepared) {
    if (!one.anchored) continue;
    VOLTLAP_DEMAND(one.log != nullptr);
    const MeasuredRun run = make_run(*one.log, one.run);
    runs.push_back(every_row ? run : averaged(run));
  }
  return runs;
}

}  // namespace voltlap::plant
