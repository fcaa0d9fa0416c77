// SPDX-License-Identifier: Apache-2.0
// The full fit: every parameter free, residuals with exact derivatives, trust-region least squares.
// Parameters p = [Em | ln R0 | ln R1 .. ln RK | ln tau1 .. ln tauK | free states | o, c | laws]; resistances and time
// constants stay positive by their logarithm. The objective is that of CircuitFit, with the time constants' smoothness
// and what is believed of the laws added.
#pragma once
#include <Eigen/Dense>

#include "learn/identify/circuit/circuit_fit.hpp"

namespace voltlap::plant {

class CircuitResiduals {
 public:
  /// `fit` must outlive the cost; `tau_centre_s`: what each branch's time constants are drawn to, weakly.
  CircuitResiduals(const CircuitFit& fit, Eigen::VectorXd tau_centre_s);

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  [[nodiscard]] Eigen::Index parameter_count() const { return at_.size(); }
  [[nodiscard]] Eigen::Index residual_count() const { return data_rows_ + prior_rows_; }
  [[nodiscard]] Eigen::Index data_rows() const { return data_rows_; }
  /// Residuals [V s^0.5], data first; `jacobian` may be null, else it has residual_count x parameter_count entries.
  void evaluate(const double* p, double* residuals, double* jacobian) const;

  /// What a step needs: J^T J and J^T r of data at rest, data under load and priors.
  struct Sums {
    Eigen::MatrixXd rest, load, prior;
    Eigen::VectorXd gradient, prior_gradient;  ///< of all; of the priors alone
    double rest_square, load_square, prior_square;
    Eigen::Index rest_rows, load_rows;
    [[nodiscard]] double cost() const { return rest_square + load_square + prior_square; }
    [[nodiscard]] Eigen::MatrixXd whole() const { return rest + load + prior; }
  };
  [[nodiscard]] Sums sums(const Eigen::VectorXd& p) const;
  [[nodiscard]] const CircuitFit& fit() const { return fit_; }
  [[nodiscard]] const CircuitLayout& layout() const { return at_; }
  [[nodiscard]] Eigen::VectorXd tau_centre_s() const { return log_centre_.array().exp(); }

  [[nodiscard]] Eigen::VectorXd pack(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const;
  [[nodiscard]] CircuitModel model_of(const Eigen::VectorXd& p) const;
  [[nodiscard]] Eigen::VectorXd states_of(const Eigen::VectorXd& p) const {
    return p.segment(at_.state(), at_.states);
  }
  /// o and c of each run, where SOC is in doubt.
  [[nodiscard]] Eigen::VectorXd doubts_of(const Eigen::VectorXd& p) const {
    return p.segment(at_.doubt(), at_.doubts);
  }

 private:
  /// Parameters as the model has them: R and tau instead of their logarithms.
  [[nodiscard]] Eigen::VectorXd plain(const double* p) const;
  /// `put(residual, first column, weights of up to four columns)` for every prior residual.
  template <class Put>
  void for_each_prior(const double* p, const Put& put) const;

  const CircuitFit& fit_;
  CircuitLayout at_;
  Eigen::VectorXd log_centre_;
  Eigen::Index data_rows_, prior_rows_;
  Eigen::MatrixXd em_rough_, r_rough_;
};

struct RefineResult {
  Eigen::VectorXd p;
  double cost = 0.0;  ///< sum of squares
  int iterations = 0;
  bool converged = false;
};
/// Levenberg and Marquardt's method on the sums: a step solves (A + mu diag A) d = -g; mu follows the ratio of real
/// and predicted decrease (H. B. Nielsen, IMM-REP-1999-05). Ends when a step lowers the cost by less than `tolerance`
/// of it.
[[nodiscard]] RefineResult refine(const CircuitResiduals& cost, const Eigen::VectorXd& start, int iterations_max = 30,
                                  double tolerance = 1e-6);

}  // namespace voltlap::plant
