// SPDX-License-Identifier: Apache-2.0
// What the plain projection of a sound log on each signature tells of the shapes without a name.
//
// Each shape by itself may be as large as references let expect; all of them together would then let a resistance be off
// by ten times what any reference shows, because nothing says that they mostly cancel. A log's projection on a
// signature, y = x' W r / x' W x, is known in every reference, and in a sound log it is about as large: y = 0 +- t. Taken
// as one more measurement of the shapes for each signature x, with H = x' W X / x' W x,
//   K = V H' (H V H' + T)^-1,   m' = m - K H m,   V' = V - K H V.
#pragma once
#include <Eigen/Dense>
#include <cstddef>
#include <vector>

#include "discrepancy/score.hpp"

namespace voltlap::plant {

/// The shapes of a log's channels: `mean` and `variance` as references let expect them, then as bounded by what the
/// `teachers` (numbers of references) show along each signature. `log`, `said`: sums by channel, [reference][channel].
void bound_projections(const Design& design, const std::vector<BlockSum>& log,
                       const std::vector<std::vector<BlockSum>>& said, const std::vector<std::size_t>& teachers,
                       Eigen::VectorXd& mean, Eigen::MatrixXd& variance);

}  // namespace voltlap::plant
