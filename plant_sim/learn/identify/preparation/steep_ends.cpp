// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/steep_ends.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kUsualSlope = 8.0;                // V over the whole SOC
constexpr double kSocSigma = 0.003, kVoltage = 5e-3;  // of SOC; V

double slope_at(const CircuitModel& model, double soc) {
  constexpr double kStep = 2e-3;
  const double low = std::clamp(soc - kStep, 0.0, 1.0 - kStep), high = std::clamp(soc + kStep, kStep, 1.0);
  return (model.ocv.value(model.em, high) - model.ocv.value(model.em, low)) / (high - low);
}

}  // namespace

void discount_steep_ends(std::vector<MeasuredRun>& runs, const CircuitModel& model) {
  VOLTLAP_DEMAND(model.em.size() == model.ocv.size() && model.em.allFinite());
  for (MeasuredRun& run : runs) {
    for (Eigen::Index row = 0; row < run.rows(); ++row) {
      const double excess = std::abs(slope_at(model, run.soc(row))) - kUsualSlope;
      if (excess <= 0.0) continue;
      const double off = excess * kSocSigma / kVoltage;
      run.weight_s(row) /= 1.0 + off * off;
    }
  }
}

}  // namespace voltlap::plant
