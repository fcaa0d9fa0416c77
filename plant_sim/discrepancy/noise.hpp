// SPDX-License-Identifier: Apache-2.0
// What a channel's residual does when nothing is wrong: white noise plus an Ornstein-Uhlenbeck process, and the Kalman
// filter whose innovations are white then. Signatures go through the same filter as the residual.
//
//   y = x + e,   e ~ N(0, w^2),   x(t + dt) = phi x(t) + n,   phi = exp(-dt/tau),   Var x = u^2
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace voltlap::plant {

struct Noise {
  double white = 1.0, coloured = 0.0, tau_s = 10.0;  ///< w, u in the channel's unit
};

class Whitener {
 public:
  /// Rows where `valid` is false carry no information; `step` of the gains is exact for uneven times.
  Whitener(const Eigen::VectorXd& time_s, std::vector<bool> valid, const Noise& noise);

  /// Innovations over their standard deviation; 0 where not valid.
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::VectorXd& values) const;
  /// ln det of the covariance of the valid rows.
  [[nodiscard]] double log_determinant() const { return log_determinant_; }

 private:
  std::vector<bool> valid_;
  Eigen::VectorXd phi_, gain_, scale_;
  double log_determinant_ = 0.0;
};

/// Most likely noise of these residuals of one kind (NaN: not valid); `least` bounds the white part from below.
[[nodiscard]] Noise fit_noise(const Eigen::VectorXd& time_s, const std::vector<Eigen::VectorXd>& residuals, double least);

[[nodiscard]] std::vector<bool> finite_rows(const Eigen::VectorXd& values);

}  // namespace voltlap::plant
