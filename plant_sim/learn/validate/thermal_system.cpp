// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_system.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_thermal.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// One quantity within the cell, and at its surface.
struct Lagging {
  double cell, surface;
  void set(double value) { cell = surface = value; }
  void go(double value, double lag_s, double dt_s) {
    surface = surface_after(surface, cell, value, lag_s, dt_s);
    cell = value;
  }
};

/// What the temperature at a row is made of, above the first reading.
struct Parts {
  double first_c;
  Lagging per_heat{0.0, 0.0}, per_entropy{0.0, 0.0}, per_start{1.0, 1.0}, per_air{0.0, 0.0}, known{0.0, 0.0};

  /// Nothing is known of what happened before: it goes on from what is recorded there.
  void begin_again(double reading_k) {
    for (Lagging* one : {&per_heat, &per_entropy, &per_start, &per_air}) one->set(0.0);
    known.set(std::isfinite(reading_k) ? reading_k : known.surface);
  }
  void go(const ThermalRecording& r, std::size_t row, const ThermalPace& pace) {
    const double dt = r.dt_s[row], stay = std::exp(-pace.rate_per_s * dt), leave = -std::expm1(-pace.rate_per_s * dt);
    const double mean = leave / pace.rate_per_s;
    per_heat.go(stay * per_heat.cell + mean * r.heat_w[row], pace.lag_s, dt);
    per_entropy.go(stay * per_entropy.cell + mean * r.heat_per_entropy(row), pace.lag_s, dt);
    per_start.go(stay * per_start.cell, pace.lag_s, dt);
    per_air.go(stay * per_air.cell + leave, pace.lag_s, dt);
    known.go(stay * known.cell + leave * (r.ambient_c[row - 1] - first_c), pace.lag_s, dt);
  }
};

double weight_of(const ThermalRecording& r, std::size_t row) {
  return std::sqrt(std::max(0.0, 0.5 * (r.dt_s[row] + (row + 1 < r.rows() ? r.dt_s[row + 1] : 0.0))));
}

/// Symmetric positive definite; its columns may be of any size.
Eigen::VectorXd solve_scaled(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) {
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right).eval();
}

}  // namespace

ThermalLayout::ThermalLayout(const std::vector<ThermalRecording>& recordings) {
  columns_ = 2 + static_cast<Index>(recordings.size());
  for (const ThermalRecording& r : recordings) {
    air_.push_back(r.air == AirFrom::kLog ? std::optional<Index>() : columns_++);
  }
}

ThermalRows thermal_rows(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace) {
  VOLTLAP_DEMAND(pace.rate_per_s > 0.0 && pace.lag_s >= 0.0);
  Index rows = 0;
  for (const auto& r : recordings) {
    rows +=
        std::count_if(r.temperature_c.begin(), r.temperature_c.end(), [](double t) { return std::isfinite(t); });
  }
  const ThermalLayout layout(recordings);
  ThermalRows out{Eigen::MatrixXd::Zero(rows, layout.columns()), Eigen::VectorXd::Zero(rows)};
  Index at = 0;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const ThermalRecording& r = recordings[k];
    Parts parts{r.start_c()};
    for (std::size_t row = 0; row < r.rows(); ++row) {
      const double reading_k = r.temperature_c[row] - parts.first_c;
      if (row > 0 && r.dt_s[row] <= 0.0) parts.begin_again(reading_k);
      if (row > 0 && r.dt_s[row] > 0.0) parts.go(r, row, pace);
      if (!std::isfinite(reading_k)) continue;
      const double weight = weight_of(r, row);
      out.columns(at, ThermalLayout::kPerCapacity) = weight * parts.per_heat.surface;
      out.columns(at, ThermalLayout::kEntropy) = weight * parts.per_entropy.surface;
      out.columns(at, layout.start(k)) = weight * parts.per_start.surface;
      if (layout.air(k)) out.columns(at, *layout.air(k)) = weight * parts.per_air.surface;
      out.rest(at++) = weight * (reading_k - parts.known.surface);
    }
  }
  return out;
}

ThermalRows assumed_rows(const std::vector<ThermalRecording>& recordings, const Eigen::VectorXd& x) {
  const ThermalLayout layout(recordings);
  VOLTLAP_DEMAND(x.size() == layout.columns() && x(0) > 0.0);
  const Index airs = layout.columns() - 2 - static_cast<Index>(recordings.size());
  ThermalRows out{Eigen::MatrixXd::Zero(1 + airs, layout.columns()), Eigen::VectorXd::Zero(1 + airs)};
  // x1 / x0 about the point: its slopes are 1 / x0 and -x1 / x0^2.
  const double entropy = x(1) / x(0);
  out.columns(0, 0) = -entropy / x(0) / kEntropySd_v_per_k;
  out.columns(0, 1) = 1.0 / x(0) / kEntropySd_v_per_k;
  out.rest(0) = -entropy / kEntropySd_v_per_k;
  Index row = 1;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    if (!layout.air(k)) continue;
    out.columns(row, *layout.air(k)) = 1.0 / recordings[k].air_sd_k;
    out.columns(row++, layout.start(k)) = -1.0 / recordings[k].air_sd_k;
  }
  return out;
}

ThermalSolution solve_thermal(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                              double variance) {
  constexpr int kRounds = 12;  // the entropy's row is straight about the last: as Gauss and Newton
  constexpr double kSettled = 1e-9;
  VOLTLAP_DEMAND(variance > 0.0);
  const ThermalRows rows = thermal_rows(recordings, pace);
  const Eigen::MatrixXd normal = rows.columns.transpose() * rows.columns;
  const Eigen::VectorXd right = rows.columns.transpose() * rows.rest;
  ThermalSolution out;
  // Without reversible heat first: an entropy of exactly none.
  const auto others = [&](const Eigen::Ref<const Eigen::VectorXd>& guess) {
    const ThermalRows assumed = assumed_rows(recordings, guess);
    return std::pair<Eigen::MatrixXd, Eigen::VectorXd>(
        normal + variance * assumed.columns.transpose() * assumed.columns,
        right + variance * assumed.columns.transpose() * assumed.rest);
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(normal.cols());
  x(0) = 1e-3;
  {
    auto [matrix, vector] = others(x);
    matrix(1, 1) += 1e12 * matrix(1, 1);
    const Eigen::VectorXd first = solve_scaled(matrix, vector);
    if (first(0) > 0.0) x = first;
    x(1) = 0.0;
  }
  for (int round = 0; round < kRounds; ++round) {
    const auto [matrix, vector] = others(x);
    const Eigen::VectorXd next = solve_scaled(matrix, vector);
    if (!next.allFinite() || !(next(0) > 0.0)) return out;
    const double moved = std::abs(next(0) - x(0)) / next(0) + std::abs(next(1) - x(1)) / next(0) / kEntropySd_v_per_k;
    x = next;
    if (moved < kSettled) break;
  }
  out.x = x;
  out.residual = rows.residual(x);
  out.cost = out.residual.squaredNorm() / variance + assumed_rows(recordings, x).residual(x).squaredNorm();
  return out;
}

}  // namespace voltlap::plant
