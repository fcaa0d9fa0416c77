// SPDX-License-Identifier: Apache-2.0
// Temperatures of recordings as a linear system. For a given rate a = G / C [1/s] and lag L [s] of the surface the
// temperature is linear in
//
//   x = (1/C, e/C, start of each recording, air of each that did not record it)       starts and airs from the first
//                                                                                     reading
// weighted by the root of the time that a row stands for. What is assumed beforehand comes as rows more:
//
//   e       0 +- 0.2 mV/K (1 sigma): full lithium-ion cells lie within +-0.4 mV/K over most of their charge;
//           Viswanathan et al., J. Power Sources 195, 2010; LFP: Forgez et al., J. Power Sources 195, 2010
//   air     the start +- ThermalRecording::air_sd_k
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "learn/validate/thermal_recording.hpp"

namespace voltlap::plant {

inline constexpr double kEntropySd_v_per_k = 2e-4;

/// What the temperature is not linear in.
struct ThermalPace {
  double rate_per_s = 0.0, lag_s = 0.0;
};

/// Which column is what.
class ThermalLayout {
 public:
  explicit ThermalLayout(const std::vector<ThermalRecording>& recordings);
  static constexpr Eigen::Index kPerCapacity = 0, kEntropy = 1;
  [[nodiscard]] Eigen::Index start(std::size_t recording) const {
    return 2 + static_cast<Eigen::Index>(recording);
  }
  [[nodiscard]] std::optional<Eigen::Index> air(std::size_t recording) const { return air_[recording]; }
  [[nodiscard]] Eigen::Index columns() const { return columns_; }

 private:
  std::vector<std::optional<Eigen::Index>> air_;
  Eigen::Index columns_ = 0;
};

/// Rows A x = y.
struct ThermalRows {
  Eigen::MatrixXd columns;
  Eigen::VectorXd rest;
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& x) const { return rest - columns * x; }
};
[[nodiscard]] ThermalRows thermal_rows(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace);

/// What is assumed, each row over its sigma; that of the entropy e = x1 / x0 straight about `x`.
[[nodiscard]] ThermalRows assumed_rows(const std::vector<ThermalRecording>& recordings, const Eigen::VectorXd& x);

/// Least squares of the rows over `variance` and of what is assumed.
struct ThermalSolution {
  double cost = 1e300;  ///< 1e300: no positive heat capacity
  Eigen::VectorXd x, residual;
  [[nodiscard]] bool found() const { return cost < 1e300; }
};
[[nodiscard]] ThermalSolution solve_thermal(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                                            double variance);

/// Of a matrix that is symmetric and positive definite, whose columns may be of any size.
[[nodiscard]] Eigen::MatrixXd solve_scaled(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& right);

/// Normal equations of everything together: the linear numbers, then rate and lag. The matrix's inverse is the
/// covariance; its solution the step of Gauss and Newton.
struct ThermalNormal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};
[[nodiscard]] ThermalNormal thermal_normal(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                                           const ThermalSolution& at, double variance);

}  // namespace voltlap::plant
