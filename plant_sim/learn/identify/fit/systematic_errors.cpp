// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/systematic_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace voltlap::plant {
namespace {

/// One error at one sigma; of the half step all of it, which `share` makes a sigma.
struct Error {
  double voltage_v, voltage_gain, current_a, current_gain, rest_current_a;
  bool half_step;
};

CellLog with_error(const CellLog& log, const Error& error) {
  CellLog out = log;
  const std::vector<bool> resting = resting_rows(log);
  for (std::size_t row = 0; row < log.rows(); ++row) {
    out.voltage_v[row] += error.voltage_v + error.voltage_gain * log.voltage_v[row];
    out.current_a[row] +=
        resting[row] ? error.rest_current_a : error.current_a + error.current_gain * log.current_a[row];
  }
  return out;
}

CurrentHold half_a_step_from(CurrentHold hold) {
  return hold == CurrentHold::kLinear ? CurrentHold::kNext : CurrentHold::kLinear;
}

}  // namespace

Eigen::VectorXd systematic_error_variance(const std::vector<PreparedLog>& prepared, bool capacity_known,
                                    const InstrumentLimits& limits, const FullFit& full) {
  const bool uncertain =
      std::any_of(prepared.begin(), prepared.end(), [](const PreparedLog& one) { return !one.hold_certain; });
  const double share = 1.0 / std::numbers::sqrt3;
  const std::array<Error, 6> errors{{{share * limits.voltage_v, 0, 0, 0, 0, false},
                                     {0, share * limits.voltage_gain, 0, 0, 0, false},
                                     {0, 0, share * limits.current_a, 0, 0, false},
                                     {0, 0, 0, share * limits.current_gain, 0, false},
                                     {0, 0, 0, 0, share * limits.rest_current_a, false},
                                     {0, 0, 0, 0, 0, uncertain}}};
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(full.packed.size());
  for (const Error& error : errors) {
    const bool any = error.half_step || error.voltage_v + error.voltage_gain + error.current_a + error.current_gain +
                                                error.rest_current_a >
                                            0.0;
    if (!any) continue;
    std::vector<CellLog> logs;
    std::vector<PreparedLog> wrong = prepared;
    for (const PreparedLog& one : prepared) logs.push_back(with_error(*one.log, error));
    double capacity = 0.0, before = 0.0;
    for (std::size_t k = 0; k < wrong.size(); ++k) {
      if (error.half_step && !wrong[k].hold_certain) wrong[k].run.hold = half_a_step_from(wrong[k].run.hold);
      before = std::max(before, span_ah(*prepared[k].log, prepared[k].run.anchor.row, prepared[k].run.hold));
      wrong[k].log = &logs[k];
      capacity = std::max(capacity, span_ah(logs[k], wrong[k].run.anchor.row, wrong[k].run.hold));
    }
    for (PreparedLog& one : wrong) one.run.capacity_ah *= capacity_known ? 1.0 : capacity / before;
    const std::vector<MeasuredRun> runs = runs_of(wrong);
    const CircuitFit fit(runs, full.fit.model.branches(), full.priors);
    const CircuitCost::Sums sums = CircuitCost(fit, full.tau_centre_s).sums(full.packed);
    Eigen::MatrixXd whole = sums.whole();
    whole.diagonal() *= 1.0 + 1e-12;
    const double sigmas = error.half_step ? share : 1.0;
    variance += (sigmas * whole.ldlt().solve(sums.gradient)).array().square().matrix();
  }
  return variance;
}

}  // namespace voltlap::plant
