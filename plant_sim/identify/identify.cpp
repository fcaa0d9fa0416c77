// SPDX-License-Identifier: Apache-2.0
#include "identify/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "core/errors.hpp"
#include "identify/file_finding.hpp"
#include "identify/identify_by_stage.hpp"
#include "identify/preparation.hpp"
#include "identify/rests_and_steps.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kWindow = 120.0;               // s of a held-out pulse
constexpr double kHysteresisLeast = 5e-3;       // V
constexpr double kBin = 0.05, kExcited = 10.0;  // SOC and seconds of fast current that make a bin of SOC known
constexpr double kRestShare = 0.5;              // of the longest rest, that a time constant may last
constexpr int kSearchEvaluations = 30;

Eigen::VectorXd first_taus(Index branches) {
  if (branches == 1) return Eigen::VectorXd::Constant(1, 60.0);
  if (branches == 2) return Eigen::Vector2d(15.0, 300.0);
  return Eigen::Vector3d(3.0, 40.0, 600.0);
}

Eigen::VectorXd error_of(const CircuitModel& model, const TestRun& run, const Eigen::VectorXd& states) {
  return simulate(model, run, states) - run.voltage_v;
}

/// Free states of each run, out of those of all.
std::vector<Eigen::VectorXd> states_by_run(const std::vector<TestRun>& runs, const Eigen::VectorXd& all,
                                           Index branches) {
  std::vector<Eigen::VectorXd> out;
  Index first = 0;
  for (const TestRun& run : runs) {
    Index count = 0;
    for (Index row = 0; row < run.rows(); ++row) {
      if (run.is_reset(row) && !run.at_rest_before[static_cast<std::size_t>(row)]) count += branches;
    }
    out.push_back(all.segment(first, count));
    first += count;
  }
  return out;
}

double mean_square(const std::vector<TestRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  double sum = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    sum += (runs[k].weight_s.array() * errors[k].array().square()).sum();
    weight += runs[k].weight_s.sum();
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

struct TrialFit {
  CircuitModel model;
  LinearSolution solution;
  std::vector<Eigen::VectorXd> states;
};

TrialFit linear_fit(const std::vector<TestRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors) {
  const CircuitFit fit(runs, taus.size(), priors);
  const Eigen::MatrixXd tau = taus.transpose().replicate(fit.r_count(), 1);
  TrialFit out;
  out.solution = fit.solve(tau);
  out.model = fit.model_of(out.solution, tau);
  out.states = states_by_run(runs, out.solution.x.tail(fit.state_count()), taus.size());
  return out;
}

std::vector<Eigen::VectorXd> errors_of(const TrialFit& fit, const std::vector<TestRun>& runs) {
  std::vector<Eigen::VectorXd> out;
  for (std::size_t k = 0; k < runs.size(); ++k) out.push_back(error_of(fit.model, runs[k], fit.states[k]));
  return out;
}

/// Both halves kept back in turn. Pulses with their first two minutes, from their onset; without pulses, minutes.
BlockScore heldout_score(const std::vector<TestRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors) {
  BlockScore total;
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}}) {
    std::vector<TestRun> kept;
    std::vector<std::vector<Block>> blocks;
    for (const TestRun& run : runs) {
      auto windows = pulse_windows(run, kWindow);
      if (windows.size() < 4) windows = time_blocks(run, kWindow);
      kept.push_back(without_every_second(run, windows, first));
      blocks.push_back(std::move(windows));
    }
    const auto errors = errors_of(linear_fit(kept, taus, priors), runs);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const BlockScore one = score_every_second(runs[k], since_onset(errors[k], blocks[k]), blocks[k], first);
      total.parts.insert(total.parts.end(), one.parts.begin(), one.parts.end());
    }
  }
  return total;
}

/// The smoothest weight whose held-out error is above the least by no more than one standard error of their
/// difference.
void choose_smoothness(const std::vector<TestRun>& runs, const Eigen::VectorXd& taus, FitPriors& priors,
                       IdentifyResult& result) {
  std::vector<std::pair<double, BlockScore>> tried;
  for (const double smoothness : {5.0, 2.0, 1.0, 0.5, 0.25, 0.1}) {
    priors.smoothness = smoothness;
    tried.emplace_back(smoothness, heldout_score(runs, taus, priors));
    result.smoothness_scores.emplace_back(smoothness, tried.back().second.mean());
  }
  const auto best = std::min_element(
      tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.second.mean() < b.second.mean(); });
  for (const auto& [smoothness, score] : tried) {
    const double doubt = standard_error_of_difference(score, best->second);
    if (score.mean() <= best->second.mean() + doubt) priors.smoothness = smoothness;
  }
  result.smoothness = priors.smoothness;
}

/// Rows that no fit explains: contactors that open, glitches. They are given no weight, and counted.
std::size_t drop_outliers(std::vector<TestRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  constexpr double kLeast = 0.05, kTimes = 10.0;  // V; times the typical error
  std::vector<double> sizes;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Index row = 0; row < runs[k].rows(); ++row) {
      if (runs[k].weight_s(row) > 0.0) sizes.push_back(std::abs(errors[k](row)));
    }
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = std::max(kLeast, kTimes * 1.4826 * *middle);
  std::size_t dropped = 0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Index row = 0; row < runs[k].rows(); ++row) {
      if (runs[k].weight_s(row) > 0.0 && std::abs(errors[k](row)) > limit) {
        runs[k].weight_s(row) = 0.0;
        ++dropped;
      }
    }
  }
  return dropped;
}

void score_orders(const std::vector<TestRun>& runs, const FitPriors& priors, IdentifyResult& result) {
  for (Index branches = 1; branches <= 3; ++branches) {
    const CircuitFit fit(runs, branches, priors);
    const Eigen::VectorXd taus = fit.search_taus(first_taus(branches), kSearchEvaluations);
    const TrialFit trial = linear_fit(runs, taus, priors);
    const auto errors = errors_of(trial, runs);
    const double square = mean_square(runs, errors), density = noise_density(runs, errors);
    double seconds = 0.0;
    for (const TestRun& run : runs) seconds += run.weight_s.sum();
    const double samples = std::max(2.0, seconds * square / density);  // independent ones
    const double parameters = static_cast<double>((2 * branches + 1) * fit.r_count());
    result.orders.push_back({static_cast<int>(branches), heldout_score(runs, taus, priors).mean(),
                             samples * std::log(square) + parameters * std::log(samples)});
  }
}

Index chosen_order(const IdentifyOptions& options, IdentifyResult& result) {
  if (options.branches > 0) return options.branches;
  const auto& o = result.orders;
  constexpr double kWorthIt = 0.95;  // a branch more must predict better by this
  if (o[2].heldout_rms_v < kWorthIt * o[1].heldout_rms_v) {
    result.notes.push_back(
        fmt::format("A third branch would predict held-out pulses at {:.2f} instead of {:.2f} mV; a cell "
                    "file holds two (--rc 3 fits three).",
                    1e3 * o[2].heldout_rms_v, 1e3 * o[1].heldout_rms_v));
  }
  return o[1].heldout_rms_v < kWorthIt * o[0].heldout_rms_v ? 2 : 1;
}

/// Slow charge and slow discharge that disagree: the rows say nothing about the circuit, their middle is the OCV.
void set_hysteresis_aside(std::vector<TestRun>& runs, double capacity, FitPriors& priors, IdentifyResult& result) {
  const auto points = hysteresis_of(runs, capacity);
  double excess = 0.0;
  for (const HysteresisPoint& point : points) excess += point.excess_v / static_cast<double>(points.size());
  // More than a tenth of a volt is no hysteresis of any chemistry but a SOC that has drifted between the two.
  constexpr double kHysteresisMost = 0.1;
  if (points.size() < 3 || excess < kHysteresisLeast || excess > kHysteresisMost) return;
  result.hysteresis_v = excess;
  result.notes.push_back(
      fmt::format("Hysteresis: slow charge and slow discharge stand {:.1f} mV apart beyond what resistance "
                  "explains. This circuit cannot represent it: the OCV is their middle, and the slow rows "
                  "are kept out of the resistances and time constants.",
                  2e3 * excess));
  for (const HysteresisPoint& point : points) priors.ocv.push_back({point.soc, point.middle_v, point.half_gap_v});
  constexpr double kSlow = 1.0 / 8.0;
  std::map<int, double> fast_s;
  for (TestRun& run : runs) {
    double since_fast = 1e9;
    for (Index row = 0; row < run.rows(); ++row) {
      const bool fast = std::abs(run.current_a(row)) >= kSlow * capacity;
      since_fast = fast ? 0.0 : since_fast + run.dt_s(row);
      if (since_fast > kWindow) run.weight_s(row) = 0.0;
      if (fast && run.weight_s(row) > 0.0)
        fast_s[static_cast<int>(std::floor(run.soc(row) / kBin))] += run.dt_s(row);
    }
  }
  const auto excited =
      std::count_if(fast_s.begin(), fast_s.end(), [](const auto& bin) { return bin.second > kExcited; });
  if (excited < 5) {
    throw InputError(runs.front().name, result.notes.back(), "pulses or a drive beside the slow test",
                     "Give another recording of this cell with currents above C/8, and this one beside it");
  }
}

double typical_resistance(const std::vector<TestRun>& runs) {
  std::vector<double> values;
  for (const TestRun& run : runs) {
    for (const StepEstimate& step : resistance_steps(run)) values.push_back(step.resistance_ohm);
  }
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Longest rest of the recordings: a branch much slower than that is not seen to relax.
double longest_rest(const std::vector<TestRun>& runs) {
  double longest = 0.0;
  for (const TestRun& run : runs) {
    for (const Segment& s : segments(run)) {
      if (s.kind == Segment::Kind::kRest) longest = std::max(longest, s.duration_s);
    }
  }
  return longest;
}

void fill_files(const std::vector<PreparedLog>& prepared, const CircuitCost& cost, const std::vector<TestRun>& runs,
                IdentifyResult& result) {
  const auto states = states_by_run(runs, cost.states_of(result.packed), result.model.branches());
  double floor = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const PreparedLog& one = prepared[k];
    const TestRun whole = make_run(*one.log, one.run);
    const Eigen::VectorXd voltage = simulate(result.model, whole, states[k]);
    result.files.push_back(file_finding(one, whole, voltage - whole.voltage_v));
    result.sections.push_back(score_of(whole, voltage));
    floor += noise_floor(whole) * whole.weight_s.sum();
    weight += whole.weight_s.sum();
  }
  result.noise_floor_v2 = floor / weight;
}

/// Where the reference study's full optimization starts: at its initial pulse optimization.
Eigen::VectorXd packed_initial_pulse(const CircuitCost& cost, const CircuitFit& fit,
                                     const std::vector<PreparedLog>& prepared) {
  const CircuitModel model = initial_pulse_model(prepared);
  LinearSolution start{Eigen::VectorXd::Zero(fit.linear_count())};
  start.x.head(model.em.size()) = model.em;
  start.x.segment(model.em.size(), model.r.size()) = model.r.reshaped();
  return cost.pack(start, model.tau);
}

}  // namespace

IdentifyResult identify(const std::vector<CellLog>& logs, const IdentifyOptions& options) {
  if (options.method && *options.method != Method::kFinalFull) return identify_by_stage(logs, options);
  const auto begin = std::chrono::steady_clock::now();
  const auto say = [&](const std::string& text) {
    if (options.progress) options.progress(text);
  };
  IdentifyResult result;
  std::vector<PreparedLog> prepared = prepare(
      logs,
      {options.capacity_ah, options.capacity_fallback_ah, options.reference_temperature_c, options.per_kelvin},
      result.notes);
  FitPriors priors;
  priors.ocv = options.ocv;
  std::vector<TestRun> runs = runs_of(prepared);
  priors.resistance_scale = typical_resistance(runs);
  if (priors.resistance_scale <= 0.0) {
    throw InputError(logs.front().path, "no step of the current that the voltage follows",
                     "at least one pulse, or a drive, with rows at most 2 s apart", "Give a recording with steps");
  }
  if (runs.size() < prepared.size()) {
    anchor_by_model(prepared, linear_fit(runs, first_taus(2), priors).model);
    runs = runs_of(prepared);
  }
  if (options.ocv.empty()) {
    for (const TestRun& run : runs) {
      for (const OcvKnowledge& rest : ocv_from_rests(run)) priors.ocv.push_back(rest);
    }
    if (priors.ocv.empty())
      result.notes.push_back(
          "No rest long enough for an OCV: it is fitted with the rest, and its interval says how well. --ocv gives "
          "a better one.");
  }
  set_hysteresis_aside(runs, prepared.front().run.capacity_ah, priors, result);
  const std::vector<TestRun> everything = runs;
  std::vector<std::vector<Block>> blocks;
  if (options.block_s > 0.0) {
    for (TestRun& run : runs) {
      blocks.push_back(time_blocks(run, options.block_s));
      run = without_every_second(run, blocks.back(), options.fit_even_blocks ? 1 : 0);
    }
  }
  priors.tau_longest_s = std::clamp(kRestShare * longest_rest(runs), 150.0, 5000.0);
  say("time constants");
  Index branches = options.branches > 0 ? options.branches : 2;
  priors.smoothness = 1.0;
  Eigen::VectorXd taus = CircuitFit(runs, branches, priors).search_taus(first_taus(branches), kSearchEvaluations);
  auto errors = errors_of(linear_fit(runs, taus, priors), runs);
  if (const std::size_t dropped = drop_outliers(runs, errors); dropped > 0) {
    result.notes.push_back(fmt::format("{} rows that no circuit follows are not used.", dropped));
    errors = errors_of(linear_fit(runs, taus, priors), runs);
  }
  priors.noise_v2_s = noise_density(runs, errors);
  say("smoothness");
  choose_smoothness(runs, taus, priors, result);
  if (options.branches == 0) {
    say("number of RC branches");
    score_orders(runs, priors, result);
    branches = chosen_order(options, result);
  }
  taus = CircuitFit(runs, branches, priors)
             .search_taus(branches == taus.size() ? taus : first_taus(branches), kSearchEvaluations);
  const TrialFit start = linear_fit(runs, taus, priors);
  say("full fit");
  // Twice: how much prior knowledge counts depends on the noise, which only a full fit shows.
  Eigen::VectorXd packed;
  std::optional<CircuitFit> fit;
  std::optional<CircuitCost> cost;
  TrialFit final;
  for (int pass = 0; pass < 2; ++pass) {
    fit.emplace(runs, branches, priors);
    cost.emplace(*fit, taus);
    if (pass == 0) {
      packed = options.method ? packed_initial_pulse(*cost, *fit, prepared)
                              : cost->pack(start.solution, taus.transpose().replicate(fit->r_count(), 1));
    }
    const RefineResult refined = refine(*cost, packed);
    packed = refined.p;
    result.iterations += refined.iterations;
    final.model = cost->model_of(packed);
    final.states = states_by_run(runs, cost->states_of(packed), branches);
    errors = errors_of(final, runs);
    priors.noise_v2_s = noise_density(runs, errors);
  }
  result.packed = packed;
  result.model = final.model;
  result.model.capacity_ah = prepared.front().run.capacity_ah;
  result.model.per_kelvin = options.per_kelvin;
  result.model.reference_temperature_c = options.reference_temperature_c;
  result.rms_v = std::sqrt(mean_square(runs, errors));
  result.noise_v2_s = priors.noise_v2_s;
  result.uncertainty = uncertainty_of(*cost, packed, result.noise_v2_s);
  if (options.block_s > 0.0) {
    double sum = 0.0, weight = 0.0;
    const auto all = errors_of(final, everything);
    for (std::size_t k = 0; k < everything.size(); ++k) {
      const std::size_t first = options.fit_even_blocks ? 1 : 0;
      for (std::size_t b = first; b < blocks[k].size(); b += 2) {
        for (Index row = blocks[k][b].first; row < blocks[k][b].last; ++row) {
          sum += everything[k].weight_s(row) * all[k](row) * all[k](row);
          weight += everything[k].weight_s(row);
        }
      }
    }
    result.rms_other_blocks_v = std::sqrt(sum / weight);
  }
  fill_files(prepared, *cost, everything, result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace voltlap::plant
