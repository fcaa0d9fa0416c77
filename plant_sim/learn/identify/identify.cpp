// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "learn/identify/fit/charge_noise.hpp"
#include "learn/identify/preparation/contradictions.hpp"
#include "learn/identify/preparation/first_estimates.hpp"
#include "learn/identify/preparation/hysteresis.hpp"
#include "learn/identify/preparation/recording_soc.hpp"
#include "learn/identify/preparation/steep_ends.hpp"
#include "learn/identify/recording/quantised_temperature.hpp"
#include "learn/methods/identify_by_stage.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// Longest rest of the recordings: a branch much slower than that is not seen to relax.
double longest_rest(const std::vector<MeasuredRun>& runs) {
  double longest = 0.0;
  for (const MeasuredRun& run : runs) {
    for (const PulseSegment& s : segments(run)) {
      if (s.kind == PulseSegment::Kind::kRest) longest = std::max(longest, s.duration_s);
    }
  }
  return longest;
}

/// Half of the shortest interval at which the current steps: what is faster is part of R0.
double shortest_time_constant(const std::vector<MeasuredRun>& runs) {
  constexpr double kStep = 0.05, kShare = 0.5, kLeast = 0.2, kMost = 30.0;  // of the largest current; s
  double shortest = kMost / kShare;
  for (const MeasuredRun& run : runs) {
    const double most = run.current_a.cwiseAbs().maxCoeff();
    for (Index row = 1; row < run.rows(); ++row) {
      const bool steps = std::abs(run.current_a(row) - run.current_a(row - 1)) > kStep * most;
      if (steps && !run.is_reset(row) && run.weight_s(row) > 0.0) shortest = std::min(shortest, run.dt_s(row));
    }
  }
  return std::clamp(kShare * shortest, kLeast, kMost);
}

/// `share` of the longest rest: half of it for a branch's search, all of it for the time constant at any one SOC.
double longest_time_constant(const std::vector<MeasuredRun>& runs, double share) {
  constexpr double kLeast = 300.0, kMost = 1e4;  // s
  return share * std::clamp(longest_rest(runs), kLeast, kMost);
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void take(const FullFit& full, double capacity_ah, IdentifyResult& result) {
  result.packed = full.packed;
  result.model = full.fit.model;
  result.plain = full.plain;
  result.model.capacity_ah = capacity_ah;
  result.noise_v2_s = full.noise_v2_s;
  result.uncertainty = full.uncertainty;
  result.smoothness = full.smoothness;
  result.smoothness_from = full.smoothness_from;
  result.smoothness_scores = full.smoothness_scores;
  result.orders = full.orders;
  result.iterations = full.iterations;
}

/// True for the rows of a recording that stand in `run`, a run of their means, with a weight.
std::vector<bool> used_rows(const MeasuredRun& whole, const MeasuredRun& run) {
  std::vector<bool> out;
  Index at = 0;
  for (Index row = 0; row < whole.rows(); ++row) {
    const double t = whole.time_s(row);
    while (at + 1 < run.rows() && std::abs(run.time_s(at + 1) - t) <= std::abs(run.time_s(at) - t)) ++at;
    out.push_back(run.weight_s(at) > 0.0 && whole.weight_s(row) > 0.0);
  }
  return out;
}

void fill_files(const std::vector<PreparedLog>& prepared, const std::vector<MeasuredRun>& runs,
                const std::vector<Eigen::VectorXd>& states, IdentifyResult& result) {
  VOLTLAP_DEMAND(runs.size() == prepared.size() && states.size() == prepared.size());
  double square = 0.0, used_weight = 0.0, floor = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const PreparedLog& one = prepared[k];
    const MeasuredRun whole = make_run(*one.log, one.run);
    const Eigen::VectorXd voltage = simulate(result.model, whole, states[k]), error = voltage - whole.voltage_v;
    result.files.push_back(recording_result(one, whole, error));
    result.sections.push_back(score_of(whole, voltage));
    floor += noise_floor(whole) * whole.weight_s.sum();
    weight += whole.weight_s.sum();
    const std::vector<bool> used = used_rows(whole, runs[k]);
    result.files.back().used = used;
    result.files.back().states_v = states[k];
    for (Index row = 0; row < whole.rows(); ++row) {
      if (!used[static_cast<std::size_t>(row)]) continue;
      square += whole.weight_s(row) * error(row) * error(row);
      used_weight += whole.weight_s(row);
    }
  }
  result.noise_floor_v2 = floor / weight;
  result.rms_v = std::sqrt(square / used_weight);
}

}  // namespace

IdentificationProblem::IdentificationProblem(const std::vector<CellLog>& recorded, const IdentifyOptions& given)
    : logs(recorded), options(given) {
  VOLTLAP_DEMAND(!logs.empty() && options.block_s >= 0.0);
  const auto begin = std::chrono::steady_clock::now();
  require_enough_rows(logs);
  for (CellLog& log : logs) smooth_quantised_temperature(log);
  if (by_stage()) return;
  priors.laws = assumed_laws(options.reference_temperature_c);
  if (options.constant) {
    result.notes.push_back("A plain circuit (--constant): one value of each resistance and time constant for all SOC.");
  }
  make_runs();
  drop_slope_of_warmed_cell();
  estimate_temperatures();
  assume_laws_of_one_temperature();
  const Hysteresis found = take_hysteresis(runs, capacity_ah, options.hysteresis_steps, priors, result.notes);
  result.hysteresis_v = found.size_v;
  result.hysteresis_in_doubt = found.in_doubt;
  if (options.ocv.empty() && result.hysteresis_v == 0.0) collect_rests();
  if (options.block_s > 0.0) hold_out_blocks();
  priors.tau_longest_s = longest_time_constant(runs, 0.5);
  priors.tau_bound_s = std::min(5000.0, longest_time_constant(runs, 1.0));
  priors.tau_shortest_s = std::min(shortest_time_constant(runs), 0.1 * priors.tau_longest_s);
  result.seconds = seconds_since(begin);
}

/// SOC first: another capacity or another idea of full is no contradiction, nor is hysteresis, for which the model has
/// a state.
std::vector<std::string> IdentificationProblem::settle_recordings() {
  std::vector<std::string> notes, unsaid, left_out;
  FitPriors with_state = priors;
  const bool has_state = take_hysteresis(runs, capacity_ah, options.hysteresis_steps, with_state, unsaid).size_v > 0.0;
  if (options.agree_soc) {
    const SettledSoc settled = settle_soc(prepared, with_state, options.capacity_ah.has_value(), notes);
    capacity_ah = settled.capacity_ah;
    result.soc_moved = settled.moved;
  }
  if (!has_state) leave_out_contradictions(prepared, priors, left_out);
  result.notes.insert(result.notes.end(), notes.begin(), notes.end());
  return left_out;
}

std::vector<MeasuredRun> IdentificationProblem::weighed_runs() const {
  std::vector<MeasuredRun> out = runs_of(prepared, options.block_s > 0.0);
  for (MeasuredRun& run : out) {
    // Beyond the ends no curve says anything: a told capacity, or that of the others, may end before a recording.
    constexpr double kBeyond = 5e-4;
    run.weight_s = (run.soc.array() >= -kBeyond && run.soc.array() <= 1.0 + kBeyond).select(run.weight_s, 0.0);
  }
  discount_steep_ends(out, priors);
  return out;
}

void IdentificationProblem::make_runs() {
  const bool every_row = options.block_s > 0.0;
  const std::vector<std::string> before = result.notes;
  prepared = prepare(logs,
                     {options.capacity_ah, options.capacity_fallback_ah, options.temperatures_c, options.hold,
                      options.ocv},
                     result.notes);
  result.capacity = prepared.front().capacity;
  constexpr double kLeast_ah = 0.1, kMost_ah = 1000.0;  // as a cell file takes it
  if (const double ah = prepared.front().run.capacity_ah; ah < kLeast_ah || ah > kMost_ah) {
    const CellLog& log = logs.front();
    throw InputError(log.path, fmt::format("{:.3g} Ah in {:.4g} s", ah, log.time_s.back() - log.time_s.front()),
                     fmt::format("a cell of {:g} to {:g} Ah", kLeast_ah, kMost_ah),
                     "Check the unit of time and current in the role map, or tell the capacity (--capacity)");
  }
  priors.ocv = options.ocv;
  priors.constant = options.constant;
  runs = runs_of(prepared, every_row);
  priors.resistance_scale = resistance_step_median(runs);
  if (priors.resistance_scale <= 0.0) {
    throw InputError(logs.front().path, "no step of the current that the voltage follows",
                     "at least one pulse, or a drive, with rows at most a minute apart", "Give a recording with steps");
  }
  capacity_ah = prepared.front().run.capacity_ah;
  const bool fixed = priors.law_priors.fixed;
  priors.law_priors = usual_law_priors(priors.resistance_scale, options.reference_temperature_c);
  priors.law_priors.fixed = fixed;
  if (runs.size() < prepared.size()) {
    const CircuitModel first = linear_fit(runs, first_taus(2), priors).model;
    anchor_by_model(prepared, first);
    settle_full_in_doubt(prepared, first);
    runs = runs_of(prepared, every_row);
  }
  VOLTLAP_DEMAND(runs.size() == prepared.size());
  if (const std::vector<std::string> left_out = settle_recordings(); !left_out.empty()) {
    result.notes = before;
    result.notes.insert(result.notes.end(), left_out.begin(), left_out.end());
    forget_left_out(prepared, logs, options.temperatures_c);
    return make_runs();
  }
  runs = weighed_runs();
}

/// Resistances of a drive are those that the cell had as it warmed: a slope on top would count the warming twice.
void IdentificationProblem::drop_slope_of_warmed_cell() {
  constexpr double kCooled = 600.0;  // s of rest after which a cell is taken to be at the room's temperature
  if (options.temperature_told || longest_rest(runs) >= kCooled) return;
  priors.laws = {.reference_temperature_c = options.reference_temperature_c};
  priors.law_priors.fixed = true;
  result.notes.push_back(
      "No temperature was recorded or told, and no rest lets the cell cool: the resistances are those that it had as "
      "it warmed, written without a change with temperature (--temperature T writes the usual one).");
}

void IdentificationProblem::collect_rests() {
  for (const MeasuredRun& run : runs) {
    for (const OcvKnowledge& rest : ocv_from_rests(run)) rests.push_back(rest);
  }
  if (rests.empty())
    result.notes.push_back(
        "No rest long enough for an OCV: it is fitted with the rest, and its interval says how well. --ocv gives "
        "a better one.");
}

void IdentificationProblem::hold_out_blocks() {
  blocks.clear();
  everything = runs;
  for (MeasuredRun& run : runs) {
    blocks.push_back(time_blocks(run, options.block_s));
    run = without_every_second(run, blocks.back(), options.fit_even_blocks ? 1 : 0);
  }
}

/// By what instruments do all day long, and by the noise of the charge that was counted; laws that were held are as
/// sure as what is believed of cells.
void IdentificationProblem::widen_intervals(const FullFit& full) {
  const bool capacity_known = options.capacity_ah.has_value();
  const Eigen::VectorXd lasting = systematic_error_variance(
                            {prepared, runs, options.block_s > 0.0, capacity_known}, options.instruments, full),
                        counted = charge_noise_variance(prepared, runs, capacity_known, full);
  VOLTLAP_DEMAND(lasting.size() == full.packed.size() && counted.size() == full.packed.size());
  Eigen::VectorXd& sigma = result.uncertainty.sigma;
  sigma = (sigma.array().square() + lasting.array() + counted.array()).sqrt();
  if (!result.laws_assumed) return;
  const ResistanceLaws::Packed believed = LawPriors{}.marginal_sigma();
  auto laws = sigma.tail(ResistanceLaws::kCount);
  laws.head(ResistanceLaws::kLogExchange) = believed.head(ResistanceLaws::kLogExchange);
  laws(ResistanceLaws::kEntropy) = believed(ResistanceLaws::kEntropy);
}

double IdentificationProblem::rms_of_held_out_blocks(const FullFit& full) const {
  VOLTLAP_DEMAND(blocks.size() == everything.size());
  double sum = 0.0, weight = 0.0;
  const auto all = errors_of(full.fit, everything);
  for (std::size_t k = 0; k < everything.size(); ++k) {
    const std::size_t first = options.fit_even_blocks ? 1 : 0;
    for (std::size_t b = first; b < blocks[k].size(); b += 2) {
      for (Index row = blocks[k][b].first; row < blocks[k][b].last; ++row) {
        sum += everything[k].weight_s(row) * all[k](row) * all[k](row);
        weight += everything[k].weight_s(row);
      }
    }
  }
  return std::sqrt(sum / weight);
}

IdentifyResult IdentificationProblem::fit(const std::optional<Eigen::VectorXd>& tau_centre_s) && {
  if (by_stage()) return identify_by_stage(logs, options);
  constexpr std::size_t kWarmingPasses = 2, kEnoughSteps = 5;
  constexpr double kSameTemperature_k = 0.5;
  const auto begin = std::chrono::steady_clock::now();
  FullFitOptions fit_options{options.branches, std::move(rests), 0.0, options.progress, {}, tau_centre_s};
  for (const PreparedLog& one : prepared)
    fit_options.instrument_v2_s =
        std::max(fit_options.instrument_v2_s, instrument_noise(make_run(*one.log, one.run)));
  // The reference study's full optimization starts at its initial pulse optimization.
  if (options.method) fit_options.start = initial_pulse_model(prepared);
  fit_options.one_temperature = one_temperature;
  fit_options.ends_undriven = ends_undriven(runs, result.capacity);
  const std::vector<std::string> notes = result.notes;
  FullFit full = full_fit(runs, priors, fit_options, result.notes);
  // A discharge or two tell no open-circuit voltage from a resistance, nor its heat.
  const std::size_t passes = step_count(runs) >= kEnoughSteps || !options.ocv.empty() ? kWarmingPasses : 0;
  for (std::size_t pass = 0; pass < passes; ++pass) {
    if (estimate_temperatures_by(full.fit.model) < kSameTemperature_k) break;
    runs = weighed_runs();
    if (options.block_s > 0.0) hold_out_blocks();
    result.notes = notes;
    full = full_fit(runs, priors, fit_options, result.notes);
  }
  note_warming();
  take(full, capacity_ah, result);
  result.laws_assumed = result.laws_assumed || full.laws_held;
  widen_intervals(full);
  if (options.block_s > 0.0) result.rms_other_blocks_v = rms_of_held_out_blocks(full);
  fill_files(prepared, runs, full.fit.states, result);
  result.seconds += seconds_since(begin);
  return std::move(result);
}

namespace {

/// Is what agreement makes of the SOC worth its many numbers? It moves each recording in two ways, by a fit that has
/// no law of a time constant yet: what it moves is often an error of that.
bool is_decisively_better(const IdentifyResult& agreed, const IdentifyResult& counted) {
  constexpr double kDecisive = 0.8;  // chosen; of 40 drawn cells
  return counted.files.size() != agreed.files.size() || agreed.rms_v < kDecisive * counted.rms_v;
}

/// By the charge as it was counted, or as the recordings agree on it.
IdentifyResult by_charge(const std::vector<CellLog>& recorded, const IdentifyOptions& options) {
  IdentifyResult agreed = IdentificationProblem(recorded, options).fit();
  if (!agreed.soc_moved) return agreed;
  if (options.progress) options.progress("the charge as it was counted");
  IdentifyOptions as_counted = options;
  as_counted.agree_soc = false;
  try {
    IdentifyResult counted = IdentificationProblem(recorded, as_counted).fit();
    return is_decisively_better(agreed, counted) ? agreed : counted;
  } catch (const InputError&) {
    return agreed;
  }
}

}  // namespace

IdentifyResult identify(const std::vector<CellLog>& recorded, const IdentifyOptions& options) {
  IdentifyResult without = by_charge(recorded, options);
  if (!without.hysteresis_in_doubt) return without;
  if (options.progress) options.progress("slow charge and discharge apart by hysteresis");
  IdentifyOptions doubted = options;
  doubted.hysteresis_steps = 1.0;
  try {
    IdentifyResult with = by_charge(recorded, doubted);
    return is_decisively_better(with, without) ? with : without;
  } catch (const InputError&) {
    return without;
  }
}

}  // namespace voltlap::plant
