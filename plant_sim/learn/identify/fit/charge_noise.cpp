// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/charge_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr int kTerms = 10;  // of the walk: what is left out is a hundredth of its variance
constexpr double kSecondsPerHour = 3600.0;

/// A stretch of a recording over which charge is counted from one known SOC.
struct Count {
  Index from, to;  ///< row of the known SOC, row after the last
  bool bridge;     ///< the SOC at its lowest point is known too: 0
};

Index row_at(const MeasuredRun& run, double time_s) {
  Index row = 0;
  (run.time_s.array() - time_s).abs().minCoeff(&row);
  return row;
}

std::vector<Count> counts_of(const PreparedLog& one, const MeasuredRun& run, bool spans_capacity) {
  const auto time_of = [&](std::size_t row) { return one.log->time_s[row]; };
  std::vector<Index> known{row_at(run, time_of(one.run.anchor.row))};
  for (const std::size_t full : one.run.full_rows) {
    if (full > one.run.anchor.row) known.push_back(row_at(run, time_of(full)));
  }
  std::vector<Count> out;
  for (std::size_t k = 0; k < known.size(); ++k)
    out.push_back({known[k], k + 1 < known.size() ? known[k + 1] : run.rows(), spans_capacity && k == 0});
  return out;
}

/// SOC error of each row by one term of the walk.
Eigen::VectorXd soc_error(const MeasuredRun& run, const Count& count, const CurrentNoise& noise, double capacity_ah,
                          int term) {
  VOLTLAP_DEMAND(count.from >= 0 && count.from < count.to && count.to <= run.rows());
  const double quiet = 0.01 * run.current_a.cwiseAbs().maxCoeff();
  Index end = count.to - 1;
  if (count.bridge) {
    run.soc.segment(count.from, count.to - count.from).minCoeff(&end);
    end += count.from;
  }
  Eigen::VectorXd walked = Eigen::VectorXd::Zero(run.rows());
  for (Index row = count.from + 1; row <= end; ++row) {
    const bool load = std::abs(run.current_a(row)) > quiet || std::abs(run.current_a(row - 1)) > quiet;
    walked(row) = walked(row - 1) + run.dt_s(row) * (load ? noise.load_a2_s : noise.rest_a2_s);
  }
  const double whole = walked(end);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(run.rows());
  if (whole <= 0.0) return out;
  const double w = (count.bridge ? term : term - 0.5) * std::numbers::pi;
  const double size = std::sqrt(2.0 * whole) / (w * kSecondsPerHour * capacity_ah);
  for (Index row = count.from; row <= end; ++row) out(row) = size * std::sin(w * walked(row) / whole);
  return out;
}

Eigen::VectorXd ocv_slopes(const CircuitModel& model, const MeasuredRun& run) {
  constexpr double kStep = 1e-3;
  Eigen::VectorXd out(run.rows());
  for (Index row = 0; row < run.rows(); ++row) {
    const double low = std::max(0.0, run.soc(row) - kStep), high = std::min(1.0, run.soc(row) + kStep);
    out(row) = (model.ocv.value(model.em, high) - model.ocv.value(model.em, low)) / std::max(high - low, kStep);
  }
  return out;
}

}  // namespace

CurrentNoise current_noise(const CellLog& log) {
  constexpr double kSteady = 0.03, kSame = 0.01;  // of the largest current; of dt
  const std::vector<bool> resting = resting_rows(log);
  const double most = largest_current(log);
  struct Mean {
    double sum = 0.0, count = 0.0;
    [[nodiscard]] double value() const { return count > 0.0 ? sum / count : 0.0; }
  } rest, load;
  for (std::size_t row = 2; row < log.rows(); ++row) {
    const double dt = log.time_s[row] - log.time_s[row - 1], before = log.time_s[row - 1] - log.time_s[row - 2];
    const double up = log.current_a[row] - log.current_a[row - 1],
                 down = log.current_a[row - 1] - log.current_a[row - 2];
    const bool steady = std::abs(up) < kSteady * most && std::abs(down) < kSteady * most;
    const bool one_kind = resting[row] == resting[row - 1] && resting[row] == resting[row - 2];
    if (!steady || !one_kind || std::abs(dt - before) > kSame * dt || log.gap[row] || log.gap[row - 1]) continue;
    Mean& mean = resting[row] ? rest : load;
    mean.sum += (up - down) * (up - down) / 6.0 * dt;
    mean.count += 1.0;
  }
  return {rest.value(), load.value()};
}

Eigen::VectorXd charge_noise_variance(const std::vector<PreparedLog>& prepared, const std::vector<MeasuredRun>& runs,
                                      bool capacity_known, const FullFit& full) {
  VOLTLAP_DEMAND(!runs.empty() && runs.size() == prepared.size());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(full.packed.size());
  const auto gradient_of = [&](const std::vector<MeasuredRun>& at) {
    const CircuitFit fit(at, full.fit.model.branches(), full.priors);
    return CircuitResiduals(fit, full.tau_centre_s).sums(full.packed);
  };
  const CircuitResiduals::Sums base = gradient_of(runs);
  Eigen::MatrixXd whole = base.whole();
  whole.diagonal() *= 1.0 + 1e-12;
  const auto solver = whole.ldlt();
  VOLTLAP_DEMAND(base.gradient.size() == full.packed.size());
  double widest = 0.0;
  for (const PreparedLog& one : prepared)
    widest = std::max(widest, span_ah(*one.log, one.run.anchor.row, one.run.hold));
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const CurrentNoise noise = current_noise(*prepared[k].log);
    if (noise.rest_a2_s + noise.load_a2_s <= 0.0) continue;
    const bool spans =
        !capacity_known && span_ah(*prepared[k].log, prepared[k].run.anchor.row, prepared[k].run.hold) == widest;
    const Eigen::VectorXd slopes = ocv_slopes(full.fit.model, runs[k]);
    for (const Count& count : counts_of(prepared[k], runs[k], spans)) {
      for (int term = 1; term <= kTerms; ++term) {
        std::vector<MeasuredRun> wrong = runs;
        wrong[k].voltage_v.array() -=
            slopes.array() * soc_error(runs[k], count, noise, prepared[k].run.capacity_ah, term).array();
        variance += solver.solve(gradient_of(wrong).gradient - base.gradient).array().square().matrix();
      }
    }
  }
  return variance;
}

}  // namespace voltlap::plant
