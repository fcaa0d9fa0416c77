// SPDX-License-Identifier: Apache-2.0
// What else is wrong beside a strong cause. Its signature is known to a few percent only, and what it misses may look
// like another cause; but only like one that moves as it does. A cause in other channels, or of another course, is held
// against what is left:
//
//   ln evidence(S + j) - ln evidence(S)   with A, a times 1/(1 + rho L c_j),  L: the gain of S
//   c_j = (sum over blocks |s' j|)^2 / (s's j'j)   raw signatures: what j could be of s, were s larger or smaller by block
#pragma once
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {

struct Beside {
  const System& system;                 ///< not tempered
  const Score& score;
  const std::vector<double>& inflation; ///< by channel
  double usual_evidence, signature_error;
};

/// The decision with the causes beside it that leave no doubt, or nothing when there are none.
[[nodiscard]] std::optional<Decision> with_further_causes(const Beside& beside, const Decision& decision);

/// c_j of a candidate beside a set, 0..1, both by these sizes of their columns.
[[nodiscard]] double likeness_by_block(const Beside& beside, const Eigen::VectorXd& one, const Eigen::VectorXd& other);

}  // namespace voltlap::plant
