// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/discount.hpp"

namespace voltlap::plant {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// S with V = S S'; what rounding made of zero stays zero.
MatrixXd root_of(const MatrixXd& variance) {
  const Eigen::LDLT<MatrixXd> factor(variance);
  const VectorXd scale = factor.vectorD().cwiseMax(0.0).cwiseSqrt();
  MatrixXd out = MatrixXd(factor.matrixL()) * scale.asDiagonal();
  return factor.transpositionsP().transpose() * out;
}

}  // namespace

Discount::Discount(const MatrixXd& gram, const MatrixXd& variance) : gram_(gram), root_(root_of(variance)) {
  MatrixXd inner = root_.transpose() * (gram_ * root_);
  inner.diagonal().array() += 1.0;
  factor_.compute(inner);
}

Discount Discount::by_variances(const MatrixXd& gram, const VectorXd& variances) {
  Discount out;
  out.gram_ = gram;
  out.deviation_ = variances.cwiseSqrt();
  MatrixXd inner = out.deviation_.asDiagonal() * gram * out.deviation_.asDiagonal();
  inner.diagonal().array() += 1.0;
  out.factor_.compute(inner);
  return out;
}

MatrixXd Discount::to_root(const MatrixXd& m) const {
  return root_.size() > 0 ? MatrixXd(root_.transpose() * m) : MatrixXd(deviation_.asDiagonal() * m);
}

MatrixXd Discount::from_root(const MatrixXd& m) const {
  return root_.size() > 0 ? MatrixXd(root_ * m) : MatrixXd(deviation_.asDiagonal() * m);
}

MatrixXd Discount::whitened(const MatrixXd& scores) const { return factor_.matrixL().solve(to_root(scores)); }

MatrixXd Discount::information() const {
  const MatrixXd taken = whitened(gram_);
  return gram_ - taken.transpose() * taken;
}

MatrixXd Discount::score(const MatrixXd& scores) const { return scores - gram_ * amounts(scores); }

MatrixXd Discount::amounts(const MatrixXd& scores) const { return from_root(factor_.solve(to_root(scores))); }

}  // namespace voltlap::plant
