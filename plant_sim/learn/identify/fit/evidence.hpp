// SPDX-License-Identifier: Apache-2.0
// How smooth each table is, from the data themselves: the roughness D y of a table is taken for normal with an
// unknown variance v, and v is what makes the recordings most probable (marginal likelihood, MacKay's fixed point).
//
//   v = |D y|^2 / gamma,   gamma = rank(D) - tr(Cov D^T D) / v        gamma: how many of D's rows the data decide
//   n^2 = r^T r / (rows - tr(A^-1 A_data))                            noise density of independent rows
//
// It holds where the residual is noise. Where the circuit itself is wrong, prediction of rows kept back decides.
// Source: D. J. C. MacKay, Bayesian interpolation, Neural Computation 4, 1992.
#pragma once
#include <Eigen/Dense>

#include "learn/identify/circuit/circuit_residuals.hpp"

namespace voltlap::plant {

struct Evidence {
  Eigen::VectorXd roughness_weights;  ///< as FitPriors has them
  double noise_v2_s = 0.0;
};
/// One update at the parameters of a fit.
[[nodiscard]] Evidence evidence_at(const CircuitResiduals& cost, const Eigen::VectorXd& p, double colour = 1.0);

struct EvidenceFit {
  FitPriors priors;
  RefineResult fit;
  int rounds = 0;
};
/// Alternates fits and updates until the variances stand still. `colour`: the residual's power density over that of
/// independent rows.
[[nodiscard]] EvidenceFit fit_by_evidence(const std::vector<MeasuredRun>& runs, Eigen::Index branches, FitPriors priors,
                                          const Eigen::VectorXd& tau_centre_s, const Eigen::VectorXd& start,
                                          double colour = 1.0);

}  // namespace voltlap::plant
