// SPDX-License-Identifier: Apache-2.0
// The model's usual discrepancy, learned from reference logs that are known to be good: how large each signature's
// coefficient is when nothing is wrong, and how much that differs from log to log.
//
// A new log's residual then has the mean X m and the covariance I + X V X' (mixed_model.hpp); V holds what differs from
// day to day of each cause too. In the Gram domain
//   A = (I + G V)^-1 G,   a = (I + G V)^-1 (g - G m):   what is left to tell a new cause by.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/score.hpp"

namespace voltlap::plant {

struct Usual {
  Eigen::VectorXd mean;
  Eigen::MatrixXd variance;           ///< V
  std::vector<double> inflation;      ///< [channel] of the white noise that the noise model leaves
  std::vector<Eigen::MatrixXd> group_mean;   ///< [group][shape x member]
  std::vector<Eigen::MatrixXd> group_variance;  ///< [group][shape x shape], of any member
  std::vector<double> group_inflation;          ///< [group] of what each member says, as for channels
  std::size_t references = 0;
  Eigen::VectorXd seen;                       ///< of causes in sound logs beyond `repeats`: variance, by column
};

struct Remaining {
  Eigen::MatrixXd information;  ///< A
  Eigen::VectorXd score;        ///< a
};

struct Reference {
  const Design* design;
  Score score;
};

/// From references; with none, only what is never known (start SOC, spread of cells) is left free.
/// The groups of it alone: what members of a group naturally differ by.
[[nodiscard]] Usual group_spread(const Design& design, const Score& score, const std::vector<Reference>& references);

/// `inflation`, by channel, divides what each says; empty: 1 with references.
[[nodiscard]] Usual usual_discrepancy(const Design& design, const Score& score, const std::vector<Reference>& references,
                                      const std::vector<double>& inflation = {});

/// Each reference judged by the others, as if it were the log; channels count over `inflation`.
[[nodiscard]] std::vector<Remaining> references_by_the_others(const Design& design, const Score& score,
                                                              const std::vector<Reference>& references,
                                                              const std::vector<double>& inflation);

/// Sums of a reference in the order of another log's columns; a column that it lacks says nothing.
[[nodiscard]] BlockSum in_order_of(const Design& design, const Reference& reference, const std::vector<double>& inflation);

[[nodiscard]] Remaining remaining(const BlockSum& sum, const Usual& usual);

}  // namespace voltlap::plant
