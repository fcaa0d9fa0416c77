// SPDX-License-Identifier: Apache-2.0
// What is wrong in one member of a group, where its effect bends: the values whose whole effect, fitted by the straight
// signatures, gives what the straight signatures gave on the log.
//
//   find v:  c(v) = b,   c(v) = A^-1 [(I + G V)^-1 X' S^-1 e(v)],   e: effect on the member's reading
//   b: sizes of the signatures on the log; X, S, V, G, A: as they were weighed (usual.hpp), of the member's group
#pragma once
#include "discrepancy/evidence.hpp"

namespace voltlap::plant {

struct CurvedValues {
  Eigen::VectorXd values;    ///< of the form's linear parameters
  Eigen::MatrixXd per_size;  ///< of a change of the signatures' sizes: what they change by
  bool inside_prior = true;
};

/// `sizes`: of the candidate's signatures, in typical sizes.
[[nodiscard]] CurvedValues curved_values(const Design& design, const NoiseModel& noise, const Usual& usual,
                                         const Cause& cause, const Candidate& candidate, const Eigen::VectorXd& sizes);

}  // namespace voltlap::plant
