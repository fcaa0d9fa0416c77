// SPDX-License-Identifier: Apache-2.0
// What a channel's residual does when nothing is wrong: white noise plus an Ornstein-Uhlenbeck process, and the Kalman
// filter whose innovations are white then. Signatures go through the same filter as the residual.
//
//   y = x + e,   e ~ N(0, w^2 + (r i)^2),   x(t + dt) = phi x(t) + n,   phi = exp(-dt/tau),   Var x = u^2
// r: ohms by which the noise i of the current sensor comes into the model's side.
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace voltlap::plant {

struct Noise {
  double white = 1.0, coloured = 0.0, tau_s = 10.0;  ///< w, u in the channel's unit
  double current_a = 0.0;                            ///< i
};

class Whitener {
 public:
  /// Rows where `valid` is false carry no information; `step` of the gains is exact for uneven times.
  /// `ohm` is r by row, or empty for none.
  Whitener(const Eigen::VectorXd& time_s, std::vector<bool> valid, const Noise& noise, const Eigen::VectorXd& ohm);

  /// Innovations over their standard deviation; 0 where not valid.
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::VectorXd& values) const;
  /// ln det of the covariance of the valid rows.
  [[nodiscard]] double log_determinant() const { return log_determinant_; }

 private:
  std::vector<bool> valid_;
  Eigen::VectorXd phi_, gain_, scale_;
  double log_determinant_ = 0.0;
};

struct NoiseSample {
  const Eigen::VectorXd* time_s;
  Eigen::VectorXd residual;  ///< NaN: not valid
  Eigen::VectorXd ohm;       ///< or empty
};
/// On a coarse grid of shares and times, or between its points too. The grid reads what is slow as slower and more.
enum class NoiseSearch { kGrid, kBetween };

inline constexpr double kLongestMemory = 300.0;  ///< s, of noise; what is slower is the model's

/// Most likely noise of residuals of one kind; `least` bounds the white part from below, `longest_s` its time from above.
[[nodiscard]] Noise fit_noise(const std::vector<NoiseSample>& samples, double least, NoiseSearch search,
                              double longest_s = kLongestMemory);

[[nodiscard]] std::vector<bool> finite_rows(const Eigen::VectorXd& values);

}  // namespace voltlap::plant
