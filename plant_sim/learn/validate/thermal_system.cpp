// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_system.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/first_order.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// One quantity within the cell, and at its surface.
struct Lagging {
  double cell, surface;
  void set(double value) { cell = surface = value; }
  void go(double value, const FirstOrderStep& follow) {
    surface = follow.after(surface, cell, value);
    cell = value;
  }
};

/// An interval's share of everything: the exponentials are the same for all parts, and mostly for the next row too.
struct Stride {
  double dt_s = 0.0, stay = 1.0, leave = 0.0;
  FirstOrderStep follow{0.0, 0.0, 1.0};

  void set(double next_dt_s, const ThermalPace& pace) {
    if (next_dt_s == dt_s) return;
    dt_s = next_dt_s;
    stay = std::exp(-pace.rate_per_s * dt_s);
    leave = -std::expm1(-pace.rate_per_s * dt_s);
    follow = pace.lag_s > 0.0 ? first_order_step(dt_s, pace.lag_s) : FirstOrderStep{0.0, 0.0, 1.0};
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
  void go(const ThermalRecording& r, std::size_t row, const Stride& s, double rate_per_s) {
    const double mean = s.leave / rate_per_s;
    per_heat.go(s.stay * per_heat.cell + mean * r.heat_w[row], s.follow);
    per_entropy.go(s.stay * per_entropy.cell + mean * r.heat_per_entropy(row), s.follow);
    per_start.go(s.stay * per_start.cell, s.follow);
    per_air.go(s.stay * per_air.cell + s.leave, s.follow);
    known.go(s.stay * known.cell + s.leave * (r.ambient_c[row - 1] - first_c), s.follow);
  }
};

double weight_of(const ThermalRecording& r, std::size_t row) {
  return std::sqrt(std::max(0.0, 0.5 * (r.dt_s[row] + (row + 1 < r.rows() ? r.dt_s[row + 1] : 0.0))));
}

/// Slopes of the weighted temperature with every number: the linear ones, rate, lag.
Eigen::MatrixXd slopes(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                       const Eigen::VectorXd& x) {
  constexpr double kStep_s = 0.05;
  const double step_per_s = 1e-4 * std::max(pace.rate_per_s, 1e-5);
  const ThermalRows here = thermal_rows(recordings, pace);
  const Eigen::VectorXd residual = here.residual(x);
  Eigen::MatrixXd out(here.columns.rows(), x.size() + 2);
  out.leftCols(x.size()) = here.columns;
  out.col(x.size()) =
      (residual - thermal_rows(recordings, {pace.rate_per_s + step_per_s, pace.lag_s}).residual(x)) / step_per_s;
  out.col(x.size() + 1) =
      (residual - thermal_rows(recordings, {pace.rate_per_s, pace.lag_s + kStep_s}).residual(x)) / kStep_s;
  return out;
}

}  // namespace

Eigen::MatrixXd solve_scaled(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& right) {
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right).eval();
}

ThermalNormal thermal_normal(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                             const ThermalSolution& at, double variance) {
  constexpr double kRate_per_s = 3e-2, kLag_s = 600.0;  // the search's ends: no wider
  VOLTLAP_DEMAND(at.found() && variance > 0.0);
  const Index n = at.x.size();
  const Eigen::MatrixXd jacobian = slopes(recordings, pace, at.x);
  ThermalNormal out{jacobian.transpose() * jacobian / variance, jacobian.transpose() * at.residual / variance};
  const ThermalRows assumed = assumed_rows(recordings, at.x);
  out.matrix.topLeftCorner(n, n) += assumed.columns.transpose() * assumed.columns;
  out.right.head(n) += assumed.columns.transpose() * assumed.residual(at.x);
  out.matrix(n, n) += 1.0 / (kRate_per_s * kRate_per_s);
  out.matrix(n + 1, n + 1) += 1.0 / (kLag_s * kLag_s);
  return out;
}

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
  Stride stride;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const ThermalRecording& r = recordings[k];
    Parts parts{r.start_c()};
    for (std::size_t row = 0; row < r.rows(); ++row) {
      const double reading_k = r.temperature_c[row] - parts.first_c;
      if (row > 0 && r.dt_s[row] <= 0.0) parts.begin_again(reading_k);
      if (row > 0 && r.dt_s[row] > 0.0) {
        stride.set(r.dt_s[row], pace);
        parts.go(r, row, stride, pace.rate_per_s);
      }
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
