// SPDX-License-Identifier: Apache-2.0
// How sure a fit is: noise with its correlation in time, an interval for every parameter, and what the data
// excited.
//
//   n^2 = mean square of the residual x its correlation time          [V^2 s]
//   Cov = n^2 (J^T J + P^T P)^-1;   b = (J^T J + P^T P)^-1 P^T (P p - prior): how far smoothness has pulled p, to
//   first order sigma_p^2 = Cov_pp + b_p^2,   95 % interval = p +- 1.96 sigma_p, for R and tau in their logarithm
//   data share of a parameter = 1 - Cov_pp x prior information: 1 when the data alone decide, 0 when the prior does
#pragma once
#include <Eigen/Dense>

#include "identify/circuit_cost.hpp"

namespace voltlap::plant {

/// Power density of a residual [V^2 s]: white noise at 1 Hz with 1 mV gives 1e-6. Blocks of several lengths are
/// compared and the largest answer counts, so that a slow error is not taken for many independent samples.
[[nodiscard]] double noise_density(const std::vector<TestRun>& runs, const std::vector<Eigen::VectorXd>& errors);

struct Uncertainty {
  Eigen::VectorXd sigma;       ///< of each parameter, in the fit's own units (ln for R and tau)
  Eigen::VectorXd data_share;  ///< 0..1
};
[[nodiscard]] Uncertainty uncertainty_of(const CircuitCost& cost, const Eigen::VectorXd& p, double noise_v2_s);

}  // namespace voltlap::plant
