// SPDX-License-Identifier: Apache-2.0
// What a log still tells of amounts b that are partly known beforehand: y = X b + X u + noise, u ~ N(0, V). With the
// Gram matrix G = X'X and scores s = X'y
//   information A = (I + G V)^-1 G,   score a = (I + G V)^-1 s,   u's own part V (I + G V)^-1 s.
// G and V span some fourteen powers of ten together (a sharp log, a shape of which next to nothing is known), where LU of
// I + G V leaves an A that is off by more than itself. With V = S S' and the Cholesky factor of I + S'G S (whose errors
// no scaling of the columns changes) A is G less a square, to rounding of G.
#pragma once
#include <Eigen/Dense>

namespace voltlap::plant {

class Discount {
 public:
  /// V whole, positive semidefinite up to rounding.
  Discount(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& variance);
  /// V diagonal, by its variances.
  [[nodiscard]] static Discount by_variances(const Eigen::MatrixXd& gram, const Eigen::VectorXd& variances);

  /// A, symmetric.
  [[nodiscard]] Eigen::MatrixXd information() const;
  /// a of every column of scores.
  [[nodiscard]] Eigen::MatrixXd score(const Eigen::MatrixXd& scores) const;
  /// The mean of u by every column of scores: V (I + G V)^-1 s.
  [[nodiscard]] Eigen::MatrixXd amounts(const Eigen::MatrixXd& scores) const;
  /// w of every column of scores: w'w = s' V (I + G V)^-1 s, what u takes of the squares of y.
  [[nodiscard]] Eigen::MatrixXd whitened(const Eigen::MatrixXd& scores) const;

 private:
  Discount() = default;
  /// S' m, S m.
  [[nodiscard]] Eigen::MatrixXd to_root(const Eigen::MatrixXd& m) const;
  [[nodiscard]] Eigen::MatrixXd from_root(const Eigen::MatrixXd& m) const;

  Eigen::MatrixXd gram_;
  Eigen::MatrixXd root_;       ///< S, or
  Eigen::VectorXd deviation_;  ///< its diagonal where it has no more
  Eigen::LLT<Eigen::MatrixXd> factor_;  ///< of I + S'G S
};

}  // namespace voltlap::plant
