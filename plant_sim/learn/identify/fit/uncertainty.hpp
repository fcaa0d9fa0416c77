// SPDX-License-Identifier: Apache-2.0
// How sure a fit is: noise with its correlation in time, an interval for every parameter, and what the data
// excited.
//
//   n^2 = mean square of the residual x its correlation time          [V^2 s]
// Residual that is noise, rest (r) and load (l) apart, since a current's noise shows under load only:
//   Cov = A^-1 (n_r^2 A_r + n_l^2 A_l + n^2 P^T P) A^-1 + d d^T,   A = A_r + A_l + P^T P,
//   A_r = sum w j j^T over rest rows,   d = -A^-1 g
//   on a grid twice as fine, since tables of straight lines stand for curves: g is the gradient at those lines, d how
//   far from them the curve that the data favour passes at a node. The posterior of a smoothing spline covers its
//   bias, on average over the curve.
//   Sources: G. Wahba, J. R. Stat. Soc. B 45 (1983) 133; D. Nychka, J. Am. Stat. Assoc. 83 (1988) 1134.
// Residual of a circuit that is only an approximation:
//   Cov = n^2 A^-1 + b b^T,   b = A^-1 P^T (P p - prior): how far smoothness has pulled p, to first order
// 95 % interval = p +- 1.96 sigma_p, for R and tau in their logarithm.
// data share of a parameter = 1 - Cov_pp x prior information: 1 when the data alone decide, 0 when the prior does
#pragma once
#include <Eigen/Dense>

#include "learn/identify/circuit/circuit_residuals.hpp"

namespace voltlap::plant {

/// Power density of a residual [V^2 s]: white noise at 1 Hz with 1 mV gives 1e-6. Blocks of several lengths are
/// compared and the largest answer counts, so that a slow error is not taken for many independent samples.
[[nodiscard]] double noise_density(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors);

/// The same with blocks of up to three hours: an error of the model lasts as long as what it depends on, the charge or
/// the temperature of a recording.
[[nodiscard]] double lasting_density(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors);

/// Noise of the instrument [V^2 s]: second differences of neighbouring rows with a steady current and equal steps. At
/// least that of 0.1 mV at 1 Hz.
[[nodiscard]] double instrument_noise(const MeasuredRun& run);

/// Is a residual noise, or the shape of something that the model lacks?
struct ResidualColour {
  double ratio = 1.0;    ///< power density of slow parts over that of single rows; 1 when no length differs for sure
  bool is_noise = true;  ///< no more than twice the instrument's noise, nor twice that of single rows at any length
};
[[nodiscard]] ResidualColour colour_of(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors,
                                       double instrument_v2_s);

struct Uncertainty {
  Eigen::VectorXd sigma;       ///< of each parameter, in the fit's own units (ln for R and tau)
  Eigen::VectorXd data_share;  ///< 0..1
};
/// Of a residual that is noise, `colour` times its white density.
[[nodiscard]] Uncertainty uncertainty_of_noise(const CircuitResiduals& cost, const Eigen::VectorXd& p, double colour);
/// Of a residual with this power density that is not.
[[nodiscard]] Uncertainty uncertainty_of(const CircuitResiduals& cost, const Eigen::VectorXd& p, double noise_v2_s);

}  // namespace voltlap::plant
