// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/quantised_temperature.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// Step of the readings [K], or 0 when they are fine, or all the same.
double step_of(const std::vector<double>& readings) {
  constexpr double kCoarse = 0.2;  // K
  const double step = smallest_step(readings);
  return step >= kCoarse ? step : 0.0;
}

/// Heat of I^2 that has not yet left the cell, in any unit.
Eigen::VectorXd heat_kept(const CellLog& log, double tau_s) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(static_cast<Index>(log.rows()));
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const double decay = std::exp(-(log.time_s[row] - log.time_s[row - 1]) / tau_s);
    const double before = log.current_a[row - 1], now = log.current_a[row];
    const double power = log.gap[row] ? 0.0 : 0.5 * (before * before + now * now);
    out(static_cast<Index>(row)) = decay * out(static_cast<Index>(row) - 1) + (1.0 - decay) * power;
  }
  const double most = out.maxCoeff();
  return most > 0.0 ? Eigen::VectorXd(out / most) : out;
}

/// Columns: b at its knots, then the heat.
Eigen::MatrixXd basis(const CellLog& log, double tau_s) {
  constexpr double kKnot = 2400.0;  // s at least between knots
  constexpr Index kKnotsMax = 8;
  const auto n = static_cast<Index>(log.rows());
  const double begin = log.time_s.front(), length = log.time_s.back() - begin;
  const Index pieces = std::clamp<Index>(static_cast<Index>(length / kKnot), 1, kKnotsMax - 1);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, pieces + 2);
  for (Index row = 0; row < n; ++row) {
    const double at = (log.time_s[static_cast<std::size_t>(row)] - begin) / length * static_cast<double>(pieces);
    const Index piece = std::min(static_cast<Index>(at), pieces - 1);
    out(row, piece) = 1.0 - (at - static_cast<double>(piece));
    out(row, piece + 1) = at - static_cast<double>(piece);
  }
  out.col(pieces + 1) = heat_kept(log, tau_s);
  return out;
}

struct Curve {
  Eigen::VectorXd value;
  double rms_k = 1e300;  ///< beyond the bands
  bool warms = false;    ///< k >= 0
};

Curve curve_of(const CellLog& log, const Eigen::VectorXd& readings, double step, double tau_s) {
  constexpr int kRounds = 30;
  VOLTLAP_DEMAND(readings.size() == static_cast<Index>(log.rows()) && step > 0.0 && tau_s > 0.0);
  constexpr Index kRowsMax = 2000;  // of the fit: temperatures are slow
  const Eigen::MatrixXd whole = basis(log, tau_s);
  const auto some = Eigen::seq(0, readings.size() - 1, std::max<Index>(1, readings.size() / kRowsMax));
  const Eigen::MatrixXd columns = whole(some, Eigen::all);
  const Eigen::VectorXd low = readings(some).array() - 0.5 * step, high = low.array() + step;
  const auto solver = Eigen::MatrixXd(columns.transpose() * columns).ldlt();
  Eigen::VectorXd target = readings(some), found, c;
  for (int round = 0; round < kRounds; ++round) {
    c = solver.solve(columns.transpose() * target);
    found = columns * c;
    target = found.cwiseMax(low).cwiseMin(high);
  }
  return {whole * c, std::sqrt((found - target).squaredNorm() / static_cast<double>(found.size())),
          c(c.size() - 1) >= 0.0};
}

}  // namespace

void smooth_quantised_temperature(CellLog& log) {
  constexpr double kKeeps = 0.15;  // of a step, rms beyond the bands; noise of the thermometer is in it
  if (log.temperature_c.size() != log.rows() || log.rows() < 3) return;
  if (!std::all_of(log.temperature_c.begin(), log.temperature_c.end(), [](double t) { return std::isfinite(t); }))
    return;
  const double step = step_of(log.temperature_c);
  if (step <= 0.0) return;
  const Eigen::VectorXd readings =
      Eigen::Map<const Eigen::VectorXd>(log.temperature_c.data(), static_cast<Index>(log.rows()));
  Curve best;
  for (const double tau_s : {100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 12800.0}) {
    Curve curve = curve_of(log, readings, step, tau_s);
    if (curve.warms && curve.rms_k < best.rms_k) best = std::move(curve);
  }
  if (!(best.rms_k < kKeeps * step)) return;
  log.temperature_c.assign(best.value.begin(), best.value.end());
  log.repairs.push_back(fmt::format(
      "The temperature comes in steps of {:.2g} K; between them it follows the heat of the current (beyond half a step "
      "{:.2g} K rms).",
      step, best.rms_k));
}

}  // namespace voltlap::plant
