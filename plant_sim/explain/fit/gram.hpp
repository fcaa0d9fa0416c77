// SPDX-License-Identifier: Apache-2.0
// Sums of squares and products of one channel's residual and signatures by block of the log, for every noise of a
// small grid. A noise is white, with an Ornstein-Uhlenbeck part beside it and a share that grows with how fast the
// current changes (a reading of the current that is late or coarse is worth little there):
//
//   y(k) = slow(k) + w(k),   cov slow(t, s) = r exp(-|t - s| / tau),   var w(k) = 1 + q rough(k)^2     (times
//   sigma^2)
//
// A scalar Kalman filter makes the errors of such a noise independent; the products of the filtered columns are
// what every fit needs. A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, 1989,
// ch. 3.
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace voltlap::explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowsXd = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct NoisePoint {
  double slow_tau_s = 0.0, slow_share = 0.0, rough_share = 0.0;  ///< tau, r, q
};
/// Its first point is white noise alone.
[[nodiscard]] std::vector<NoisePoint> noise_grid(bool with_rough);

/// What a channel brings to a fit.
struct ChannelColumns {
  VectorXd time_s, rough;
  RowsXd values;              ///< bin x column, the residual last
  std::vector<Index> column;  ///< number of each column in the problem
  std::vector<Index> block;   ///< of each bin; never decreasing
};

/// Products of the filtered columns.
struct Products {
  MatrixXd gram;  ///< the residual last
  double log_det = 0.0, count = 0.0;
};
class ChannelGram {
 public:
  ChannelGram(ChannelColumns columns, std::vector<NoisePoint> grid, Index blocks);
  std::vector<Index> column;      ///< as above, without the residual
  std::vector<NoisePoint> noise;  ///< the grid
  std::vector<Products> all;      ///< [noise], of the whole log
  /// Of one block: reckoned when this noise is first asked for, as few of the grid ever are.
  [[nodiscard]] const Products& of_block(std::size_t noise, Index block) const;

 private:
  ChannelColumns columns_;
  Index blocks_;
  mutable std::vector<std::vector<Products>> by_block_;  // [noise][block]
};

}  // namespace voltlap::explain
