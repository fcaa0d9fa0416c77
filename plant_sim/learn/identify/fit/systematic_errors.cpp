// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/systematic_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSigmaOfBound = 1.0 / std::numbers::sqrt3;  // of errors spread evenly up to the bound

/// Of the step from a hold that is assumed to the opposite one: as when that is right once in three and the middle once
/// in ten. A logger that reads just after each change moves a part of the first branch into R0, and nothing shows it.
constexpr double kOtherHold = 0.6;

/// One error at one sigma; of another hold all of it.
struct Error {
  double voltage_v, voltage_gain, current_a, current_gain, rest_current_a;
  bool other_hold, body = false, thermometer = false;
  [[nodiscard]] bool is_any() const {
    return other_hold || body || thermometer ||
           voltage_v + voltage_gain + current_a + current_gain + rest_current_a > 0.0;
  }
};

bool has_thermometer(const PreparedLog& one) {
  const std::vector<double>& read = one.log->temperature_c;
  return !one.temperature_estimated &&
         std::any_of(read.begin(), read.end(), [](double at_c) { return std::isfinite(at_c); });
}

std::array<Error, 8> errors_at_one_sigma(const std::vector<PreparedLog>& prepared, const InstrumentLimits& limits) {
  const bool uncertain =
      std::any_of(prepared.begin(), prepared.end(), [](const PreparedLog& one) { return !one.hold_certain; });
  const bool reckoned =
      std::any_of(prepared.begin(), prepared.end(), [](const PreparedLog& one) { return one.temperature_estimated; });
  const bool read = std::any_of(prepared.begin(), prepared.end(), has_thermometer);
  return {{{kSigmaOfBound * limits.voltage_v, 0, 0, 0, 0, false},
           {0, kSigmaOfBound * limits.voltage_gain, 0, 0, 0, false},
           {0, 0, kSigmaOfBound * limits.current_a, 0, 0, false},
           {0, 0, 0, kSigmaOfBound * limits.current_gain, 0, false},
           {0, 0, 0, 0, kSigmaOfBound * limits.rest_current_a, false},
           {0, 0, 0, 0, 0, uncertain},
           {0, 0, 0, 0, 0, false, reckoned},
           {0, 0, 0, 0, 0, false, false, read}}};
}

/// As if the thermometer, which sits on the surface, showed what the cell had a while ago.
void bring_forward(const CellLog& log, double by_s, std::vector<double>& temperature_c) {
  std::size_t later = 0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    while (later + 1 < log.rows() && log.time_s[later] < log.time_s[row] + by_s && !log.gap[later + 1]) ++later;
    later = std::max(later, row);
    if (std::isfinite(log.temperature_c[later])) temperature_c[row] = log.temperature_c[later];
  }
}

CellLog with_error(const PreparedLog& one, const Error& error) {
  constexpr double kBody = 0.5;   // of a warming that was reckoned with an assumed body
  constexpr double kLag_s = 15.0;  // assumed: of a thermometer on the surface of a cell, 0 to 30 s
  const CellLog& log = *one.log;
  CellLog out = log;
  if (error.body && one.temperature_estimated) {
    for (double& at_c : out.temperature_c) at_c += kBody * (at_c - log.temperature_c.front());
  }
  if (error.thermometer && has_thermometer(one)) bring_forward(log, kLag_s, out.temperature_c);
  const std::vector<bool> resting = resting_rows(log);
  for (std::size_t row = 0; row < log.rows(); ++row) {
    out.voltage_v[row] += error.voltage_v + error.voltage_gain * log.voltage_v[row];
    out.current_a[row] +=
        resting[row] ? error.rest_current_a : error.current_a + error.current_gain * log.current_a[row];
  }
  return out;
}

CurrentHold opposite(CurrentHold hold) {
  return hold == CurrentHold::kNext ? CurrentHold::kPrevious : CurrentHold::kNext;
}

/// The recordings as they would be with an error, into `logs`; a capacity that they span themselves follows.
std::vector<PreparedLog> prepared_with(const Error& error, const std::vector<PreparedLog>& prepared,
                                       bool capacity_known, std::vector<CellLog>& logs) {
  logs.clear();
  for (const PreparedLog& one : prepared) logs.push_back(with_error(one, error));
  std::vector<PreparedLog> wrong = prepared;
  double capacity = 0.0, before = 0.0;
  for (std::size_t k = 0; k < wrong.size(); ++k) {
    if (error.other_hold && !wrong[k].hold_certain) wrong[k].run.hold = opposite(wrong[k].run.hold);
    before = std::max(before, counted_ah(*prepared[k].log, prepared[k].run.anchor.row, prepared[k].run.hold));
    wrong[k].log = &logs[k];
    capacity = std::max(capacity, counted_ah(logs[k], wrong[k].run.anchor.row, wrong[k].run.hold));
  }
  VOLTLAP_DEMAND(before > 0.0);
  for (PreparedLog& one : wrong) one.run.capacity_ah *= capacity_known ? 1.0 : capacity / before;
  return wrong;
}

/// Rows count as they did in the fit.
std::vector<MeasuredRun> with_weights_of(std::vector<MeasuredRun> runs, const std::vector<MeasuredRun>& fitted) {
  VOLTLAP_DEMAND(runs.size() == fitted.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (runs[k].rows() == fitted[k].rows()) runs[k].weight_s = fitted[k].weight_s;
  }
  return runs;
}

}  // namespace

Eigen::VectorXd systematic_error_variance(const FittedRecordings& recordings, const InstrumentLimits& limits,
                                          const FullFit& full) {
  const std::vector<PreparedLog>& prepared = recordings.prepared;
  VOLTLAP_DEMAND(!prepared.empty() && full.packed.allFinite());
  const auto sums_of = [&](const std::vector<PreparedLog>& logs) {
    const std::vector<MeasuredRun> runs =
        with_weights_of(runs_of(logs, recordings.every_row), recordings.runs);
    const CircuitFit fit(runs, full.fit.model.branches(), full.priors);
    return CircuitResiduals(fit, full.tau_centre_s).sums(full.packed);
  };
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(full.packed.size());
  std::optional<CircuitResiduals::Sums> base;
  for (const Error& error : errors_at_one_sigma(prepared, limits)) {
    if (!error.is_any()) continue;
    if (!base) base = sums_of(prepared);
    std::vector<CellLog> logs;
    const CircuitResiduals::Sums wrong =
        sums_of(prepared_with(error, prepared, recordings.capacity_known, logs));
    Eigen::MatrixXd whole = wrong.whole();
    whole.diagonal() *= 1.0 + 1e-12;
    // The fit's answer to the error: what it adds to a gradient that is not quite zero before.
    const Eigen::VectorXd change = whole.ldlt().solve(wrong.gradient - base->gradient);
    const double sigmas = error.other_hold ? kOtherHold : 1.0;
    variance += (sigmas * change).array().square().matrix();
  }
  VOLTLAP_DEMAND(variance.allFinite());
  return variance;
}

}  // namespace voltlap::plant
