// SPDX-License-Identifier: Apache-2.0
// What sound logs have in common and what differs between them, from their sums alone:
//
//   log k:  y_k = X_k (m + u_k) + noise,   m ~ N(0, a^2),  u_k ~ N(0, b^2)    one a and one b for each kind of column
//
// a and b by expectation-maximisation with inverse-gamma priors around what is usual (Gelman, 2006, on why variances of
// few groups need them).
#pragma once
#include <Eigen/Dense>
#include <vector>

namespace voltlap::plant {

/// Gram matrix of the whitened columns and their products with the whitened residual.
struct LogSums {
  Eigen::MatrixXd gram;
  Eigen::VectorXd score;
};

/// By column: kind, and the sizes of a and b that are expected.
struct ColumnPrior {
  std::vector<std::size_t> kin;
  Eigen::VectorXd usual, repeats;
  double columns = 4.0;  ///< what the expected sizes weigh, in columns of the kind
  double start = 1.0;    ///< b begins at so many of the expected sizes: from too small it hardly grows
};

struct MixedModel {
  Eigen::VectorXd mean;                ///< m
  Eigen::MatrixXd mean_covariance;
  Eigen::VectorXd between;             ///< b^2 by column
  std::vector<Eigen::VectorXd> own;    ///< m + u_k of every log
  /// Covariance of a new log's coefficients.
  [[nodiscard]] Eigen::MatrixXd variance() const;
};

[[nodiscard]] MixedModel mixed_model(const std::vector<LogSums>& logs, const ColumnPrior& prior, int rounds);

}  // namespace voltlap::plant
