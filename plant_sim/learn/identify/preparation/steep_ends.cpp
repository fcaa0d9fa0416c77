// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/steep_ends.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kUsualSlope = 8.0;  // V over the whole SOC

/// By how much the curve is steeper than usual at a SOC [V]; 0 where it is not.
double excess_at(const CircuitModel& model, double soc) {
  constexpr double kStep = 2e-3;
  const double low = std::clamp(soc - kStep, 0.0, 1.0 - kStep), high = std::clamp(soc + kStep, kStep, 1.0);
  const double slope = (model.ocv.value(model.em, high) - model.ocv.value(model.em, low)) / (high - low);
  return std::max(0.0, std::abs(slope) - kUsualSlope);
}

void discount(std::vector<MeasuredRun>& runs, const CircuitModel& model, double sigma_soc, double sigma_v) {
  for (MeasuredRun& run : runs) {
    for (Index row = 0; row < run.rows(); ++row) {
      const double off = excess_at(model, run.soc(row)) * sigma_soc / sigma_v;
      run.weight_s(row) /= 1.0 + off * off;
    }
  }
}

}  // namespace

void discount_steep_ends(std::vector<MeasuredRun>& runs, const FitPriors& priors) {
  constexpr double kSoc = 0.003, kVoltage = 5e-3;  // V; of the quick fit
  constexpr double kLeast_v = 1e-3, kFarWorse = 4.0;
  VOLTLAP_DEMAND(!runs.empty());
  std::vector<MeasuredRun> eased = runs;
  discount(eased, linear_fit(runs, first_taus(2), priors).model, kSoc, kVoltage);
  const FittedCircuit quick = linear_fit(eased, first_taus(2), priors);
  const auto errors = errors_of(quick, runs);
  std::vector<double> steep_soc, steep_v, usual_v;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Index row = 0; row < runs[k].rows(); ++row) {
      if (runs[k].weight_s(row) <= 0.0) continue;
      const double excess = excess_at(quick.model, runs[k].soc(row)), error = std::abs(errors[k](row));
      (excess > 0.0 ? steep_v : usual_v).push_back(error);
      if (excess > 0.0) steep_soc.push_back(error / (excess + kUsualSlope));
    }
  }
  if (steep_soc.empty() || usual_v.empty()) return;
  const double sigma_v = std::max(kLeast_v, median(std::move(usual_v))), sigma_soc = median(std::move(steep_soc));
  if (median(std::move(steep_v)) > kFarWorse * sigma_v) discount(runs, quick.model, sigma_soc, sigma_v);
}

}  // namespace voltlap::plant
