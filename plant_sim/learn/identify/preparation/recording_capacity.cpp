// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/recording_capacity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kSearched = 0.15;  // of the capacity, either way

MeasuredRun run_at(const PreparedLog& one, double scale) {
  PreparedLog tried = one;
  tried.run.capacity_ah *= scale;
  return averaged(make_run(*tried.log, tried.run));
}

/// Error of a model at a capacity, over the SOC that the others have been at, without its mean [V]: what a shifted OCV
/// leaves is the recording's own.
double error_at(const PreparedLog& one, const CircuitModel& model, double soc_low, double scale) {
  const MeasuredRun run = run_at(one, scale);
  const Eigen::VectorXd error = simulate(model, run) - run.voltage_v;
  double square = 0.0, weight = 0.0;
  for (Index row = 0; row < run.rows(); ++row) {
    if (run.soc(row) < soc_low) continue;
    square += run.weight_s(row) * error(row) * error(row);
    weight += run.weight_s(row);
  }
  return weight > 0.0 ? std::sqrt(square / weight) : 0.0;
}

struct Scaled {
  double scale, error_v;
};

Scaled best_scale(const PreparedLog& one, const CircuitModel& model, double soc_low) {
  constexpr double kFinest = 2e-3;
  Scaled best{1.0, error_at(one, model, soc_low, 1.0)};
  for (double step = kSearched / 3.0; step > kFinest; step *= 0.4) {
    const double from = best.scale;
    for (int k = -3; k <= 3; ++k) {
      const double scale = std::clamp(from + step * k, 1.0 - kSearched, 1.0 + kSearched);
      const double error = error_at(one, model, soc_low, scale);
      if (error < best.error_v) best = {scale, error};
    }
  }
  return best;
}

double lowest_soc(const std::vector<MeasuredRun>& runs) {
  double low = 1.0;
  for (const MeasuredRun& run : runs) low = std::min(low, run.soc.minCoeff());
  return low;
}

}  // namespace

namespace {

/// The capacity of a recording that the others tell, if they do; `runs`: as the recordings stand.
std::optional<double> told_by_others(std::size_t k, const std::vector<PreparedLog>& prepared,
                                     const std::vector<MeasuredRun>& runs, const FitPriors& priors,
                                     std::vector<std::string>& notes) {
  constexpr double kBetter = 0.6, kWorthIt = 0.015, kMargin = 0.02;  // of the error; of the capacity; SOC
  std::vector<MeasuredRun> others = runs;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
  const CircuitModel model = linear_fit(others, first_taus(2), priors).model;
  const double soc_low = lowest_soc(others) + kMargin, as_it_is = error_at(prepared[k], model, soc_low, 1.0);
  const Scaled best = best_scale(prepared[k], model, soc_low);
  const bool at_end = std::abs(best.scale - 1.0) > 0.99 * kSearched;
  if (at_end || best.error_v > kBetter * as_it_is || std::abs(best.scale - 1.0) < kWorthIt) return std::nullopt;
  const double capacity_ah = prepared[k].run.capacity_ah * best.scale;
  notes.push_back(fmt::format(
      "{} agrees with the other recordings at a capacity of {:.3f} Ah ({:+.1f} %; error {:.1f} instead of {:.1f} mV): "
      "its SOC is counted with that. A cell that aged between tests, or another counter.",
      std::filesystem::path(prepared[k].log->path).filename().string(), capacity_ah, 100.0 * (best.scale - 1.0),
      1e3 * best.error_v, 1e3 * as_it_is));
  return capacity_ah;
}

}  // namespace

double settle_capacities(std::vector<PreparedLog>& prepared, const FitPriors& priors, std::vector<std::string>& notes) {
  constexpr double kSpan = 0.5;  // of SOC
  VOLTLAP_DEMAND(!prepared.empty());
  const double common = prepared.front().run.capacity_ah;
  if (prepared.size() < 2) return common;
  std::vector<MeasuredRun> runs = runs_of(prepared);
  VOLTLAP_DEMAND(runs.size() == prepared.size());
  const auto span = [&](std::size_t k) { return runs[k].soc.maxCoeff() - runs[k].soc.minCoeff(); };
  std::size_t widest = 0;
  for (std::size_t k = 1; k < runs.size(); ++k) {
    if (span(k) > span(widest)) widest = k;
  }
  std::vector<double> told{common};
  std::vector<bool> is_told(prepared.size(), false);
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    if (k == widest || span(k) < kSpan) continue;
    const std::optional<double> capacity_ah = told_by_others(k, prepared, runs, priors, notes);
    if (!capacity_ah) continue;
    is_told[k] = true;
    prepared[k].run.capacity_ah = *capacity_ah;
    runs[k] = averaged(make_run(*prepared[k].log, prepared[k].run));
    told.push_back(*capacity_ah);
  }
  const double middle = median(told);
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    if (k != widest && !is_told[k]) prepared[k].run.capacity_ah = middle;
  }
  return middle;
}

}  // namespace voltlap::plant
