// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/projections.hpp"

#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMargin = 2.0;     // on the size of a projection, as few references tell it
constexpr double kOfOneNumber = 3.0;  // the same of a charge, of which each reference tells one number
constexpr double kReferences = 3.0; // what all errors of a channel weigh against a signature's own projections
constexpr double kSlow = 0.05;      // of an energy: what may be slow error where all of it is as large as noise
constexpr double kConstant = 1.0;   // the same of a charge, whose error is one constant: noise hides it wholly
constexpr double kShare = 0.15;     // of a channel's error that lies along one signature

/// Variance of the projection on column `k` of a channel's sums.
double expected_square(const BlockSum& log, const std::vector<const BlockSum*>& teachers, Index k, Balance balance) {
  const double slow = balance == Balance::kCharge ? kConstant : kSlow;
  const double margin = balance == Balance::kCharge ? kOfOneNumber : kMargin;
  double own = 0.0, count = 0.0, error = 0.0, logs = 0.0;
  for (const BlockSum* theirs : teachers) {
    if (theirs->rows <= 0.0) continue;
    const double energy = theirs->energy / theirs->rows;
    error += std::max(slow * energy, energy - 1.0);
    logs += 1.0;
    if (theirs->gram(k, k) <= 0.0) continue;
    own += std::pow(theirs->score(k) / theirs->gram(k, k), 2);
    count += 1.0;
  }
  if (logs == 0.0) return 0.0;
  const double all = kShare * kShare * (error / logs) * log.rows / log.gram(k, k);
  return margin * margin * (own + kReferences * all) / (count + kReferences);
}

}  // namespace

void bound_projections(const Design& design, const std::vector<BlockSum>& log,
                       const std::vector<std::vector<BlockSum>>& said, const std::vector<std::size_t>& teachers,
                       VectorXd& mean, MatrixXd& variance) {
  for (std::size_t c = 0; c < log.size(); ++c) {
    std::vector<const BlockSum*> theirs;
    for (const std::size_t k : teachers) theirs.push_back(&said[k][c]);
    std::vector<Index> shapes, learned, signatures;
    std::vector<double> squares;
    for (std::size_t k = 0; k < design.columns.size(); ++k) {
      const Column& column = design.columns[k];
      const auto i = static_cast<Index>(k);
      if (column.effect[c].size() == 0 || column.free > 0.0 || column.key.starts_with("local/")) continue;
      if (column.cause < 0) learned.push_back(i);
      if (column.cause < 0 && !column.of_start) shapes.push_back(i);
      if (log[c].gram(i, i) <= 0.0) continue;
      const double square = expected_square(log[c], theirs, i, design.comparison.channels[c].balance);
      if (square <= 0.0) continue;
      signatures.push_back(i);
      squares.push_back(square);
    }
    if (signatures.empty() || shapes.empty()) continue;
    const VectorXd information = log[c].gram.diagonal()(signatures);
    const MatrixXd projection = information.cwiseInverse().asDiagonal() * log[c].gram(signatures, shapes);
    MatrixXd total = projection * variance(shapes, shapes) * projection.transpose();
    total.diagonal() += Eigen::Map<const VectorXd>(squares.data(), static_cast<Index>(squares.size()));
    const Eigen::LLT<MatrixXd> factor(total);
    // What a log's own start tells of is not bounded, but knows of the shapes that are.
    const MatrixXd across = factor.matrixL().solve(projection * variance(shapes, learned));
    const VectorXd shown = factor.matrixL().solve(projection * mean(shapes));
    mean(learned) -= across.transpose() * shown;
    variance(learned, learned) -= across.transpose() * across;
  }
}

}  // namespace voltlap::plant
