// SPDX-License-Identifier: Apache-2.0
// How warm cells were that nobody measured, and whether the recordings tell what the temperature changes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "learn/identify/identify.hpp"
#include "learn/identify/preparation/first_estimates.hpp"
#include "learn/identify/recording/estimated_temperature.hpp"

namespace voltlap::plant {

using Eigen::Index;

/// A discharge without a thermometer warms all the same: by what is told or assumed of the cell's body. What stays
/// within a kelvin is left as it is.
void IdentificationProblem::estimate_temperatures() {
  constexpr double kWorthIt_k = 1.0, kJoules = 1e3;
  if (!options.thermal || priors.law_priors.fixed) return;
  // By what steps show: one discharge alone does not tell its open-circuit voltage from a resistance.
  const HeatEstimate heat{kWholeOverStep * priors.resistance_scale, priors.laws.reference_temperature_c,
                          kJoules * priors.laws.ohmic_kj_per_mol, {}, 0.0};
  bool any = false;
  for (PreparedLog& one : prepared) {
    CellLog& log = logs[static_cast<std::size_t>(one.log - logs.data())];
    const bool recorded = std::any_of(log.temperature_c.begin(), log.temperature_c.end(),
                                      [](double t) { return std::isfinite(t); });
    if (recorded) continue;
    const double start_c = one.run.temperature_c;
    std::vector<double> warming =
        estimated_temperature(log, one.run.hold, options.thermal(capacity_ah), heat, {start_c, start_c});
    if (*std::max_element(warming.begin(), warming.end()) - warming.front() < kWorthIt_k) continue;
    log.temperature_c = std::move(warming);
    one.temperature_estimated = any = true;
  }
  if (any) runs = weighed_runs();
}

/// How far apart the temperatures are at which the same SOC was passed under load, in the median over SOC [K]: where a
/// cell warms as it empties, what the SOC does and what the temperature does are one. A warming that was reckoned with
/// an assumed body tells no law: such a recording counts as at the temperature at which it began.
double IdentificationProblem::temperature_spread() const {
  constexpr double kBins = 20.0, kLoad = 0.05;  // of SOC; of the largest current
  std::map<int, std::pair<double, double>> ends;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const MeasuredRun& run = runs[k];
    const double most = run.current_a.cwiseAbs().maxCoeff();
    for (Index row = 0; row < run.rows(); ++row) {
      if (std::abs(run.current_a(row)) < kLoad * most || run.weight_s(row) <= 0.0) continue;
      const double at_c = prepared[k].temperature_estimated ? prepared[k].run.temperature_c : run.temperature_c(row);
      const auto [at, is_new] = ends.try_emplace(static_cast<int>(std::floor(kBins * run.soc(row))), at_c, at_c);
      at->second = {std::min(at->second.first, at_c), std::max(at->second.second, at_c)};
    }
  }
  std::vector<double> spreads;
  for (const auto& [bin, end] : ends) spreads.push_back(end.second - end.first);
  return spreads.empty() ? 0.0 : median(std::move(spreads));
}

/// Only recordings at other temperatures tell a law over the temperature, or one that warms and is followed to its
/// noise: an error of the circuit would be taken for a law.
void IdentificationProblem::assume_laws_of_one_temperature() {
  constexpr double kOther_k = 8.0;  // chosen: what a cell warms in a discharge at 1C or 2C
  if (priors.law_priors.fixed || temperature_spread() > kOther_k) return;
  const auto estimated = [](const PreparedLog& one) { return one.temperature_estimated; };
  if (std::any_of(prepared.begin(), prepared.end(), estimated)) {
    result.laws_assumed = true;
    priors.law_priors.hold_temperature();
  } else {
    one_temperature = true;
  }
}

/// The same by what a fit says of the heat: current times what the voltage lacks of the open-circuit one, which is what
/// the file's own simulation makes of it. Returns by how much a temperature has changed at most [K].
double IdentificationProblem::estimate_temperatures_by(const CircuitModel& model) {
  constexpr double kMillivolt = 1e-3;
  double most = 0.0;
  for (const PreparedLog& one : prepared) {
    if (!one.temperature_estimated) continue;
    const MeasuredRun run = make_run(*one.log, one.run);
    HeatEstimate heat{0.0, model.laws.reference_temperature_c, 0.0, {}, kMillivolt * model.laws.entropy_mv_per_k};
    for (const double soc : run.soc) heat.ocv_v.push_back(model.ocv.value(model.em, soc));
    CellLog& log = logs[static_cast<std::size_t>(one.log - logs.data())];
    const double start_c = one.run.temperature_c;
    std::vector<double> warming =
        estimated_temperature(log, one.run.hold, options.thermal(capacity_ah), heat, {start_c, start_c});
    for (std::size_t row = 0; row < warming.size(); ++row)
      most = std::max(most, std::abs(warming[row] - log.temperature_c[row]));
    log.temperature_c = std::move(warming);
  }
  return most;
}

void IdentificationProblem::note_warming() {
  for (const PreparedLog& one : prepared) {
    if (!one.temperature_estimated) continue;
    const std::vector<double>& warmed = one.log->temperature_c;
    result.notes.push_back(fmt::format("{}: no temperature was recorded; by the heat that it makes and its body the "
                                       "cell went from {:.1f} to {:.1f} degC.",
                                       std::filesystem::path(one.log->path).filename().string(), warmed.front(),
                                       *std::max_element(warmed.begin(), warmed.end())));
  }
}

}  // namespace voltlap::plant
