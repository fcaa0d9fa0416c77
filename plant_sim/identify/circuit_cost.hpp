// SPDX-License-Identifier: Apache-2.0
// The full fit: every parameter free, residuals with exact derivatives, trust-region least squares by Ceres.
// Parameters p = [Em | ln R0 | ln R1 .. ln RK | ln tau1 .. ln tauK | free states]; resistances and time constants
// stay positive by their logarithm. The objective is that of CircuitFit, with the time constants' smoothness added.
#pragma once
#include <Eigen/Dense>

#include "identify/circuit_fit.hpp"

namespace voltlap::plant {

class CircuitCost {
 public:
  /// `fit` must outlive the cost; `tau_centre_s`: what each branch's time constants are drawn to, weakly.
  CircuitCost(const CircuitFit& fit, Eigen::VectorXd tau_centre_s);

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  [[nodiscard]] Eigen::Index parameter_count() const { return parameters_; }
  [[nodiscard]] Eigen::Index residual_count() const { return data_rows_ + prior_rows_; }
  [[nodiscard]] Eigen::Index data_rows() const { return data_rows_; }
  /// Residuals [V s^0.5], data first; `jacobian` may be null, else it has residual_count x parameter_count entries.
  void evaluate(const double* p, double* residuals, double* jacobian) const;

  [[nodiscard]] Eigen::VectorXd pack(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const;
  [[nodiscard]] CircuitModel model_of(const Eigen::VectorXd& p) const;
  [[nodiscard]] Eigen::VectorXd states_of(const Eigen::VectorXd& p) const { return p.tail(fit_.state_count()); }

 private:
  void data_residuals(const double* p, double* residuals, double* jacobian) const;
  void prior_residuals(const double* p, double* residuals, double* jacobian) const;

  const CircuitFit& fit_;
  Eigen::VectorXd log_centre_;
  Eigen::Index em_, r_, branches_, first_tau_, first_state_, parameters_, data_rows_ = 0, prior_rows_ = 0;
  Eigen::MatrixXd em_rough_, r_rough_;
};

struct RefineResult {
  Eigen::VectorXd p;
  double cost = 0.0;  ///< half of the sum of squares, as Ceres counts
  int iterations = 0;
  bool converged = false;
};
[[nodiscard]] RefineResult refine(const CircuitCost& cost, const Eigen::VectorXd& start, int iterations_max = 20);

}  // namespace voltlap::plant
