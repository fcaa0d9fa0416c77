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

/// What references say of the shapes without a name.
struct Learned {
  Eigen::VectorXd mean;
  Eigen::MatrixXd variance;  ///< V of these, before it is widened
  std::vector<double> size;  ///< [channel] share of the usual sizes of the shapes, see size_of_errors; empty: 1
};

/// The references once they have been asked: what each says by channel, what all of them teach, and all but each.
struct Knowledge {
  std::vector<const Design*> designs;
  std::vector<std::vector<BlockSum>> said;  ///< [reference][channel], in the order of the log's columns
  Learned of_all;
  std::vector<Learned> of_the_others;       ///< [reference], empty with one
};
[[nodiscard]] Knowledge knowledge_of(const Design& design, const std::vector<Reference>& references);

/// The groups alone: what members of a group naturally differ by.
[[nodiscard]] Usual group_spread(const Design& design, const Score& score, const std::vector<Reference>& references);

/// The shapes and what no log tells beforehand, without the groups and without what sound logs show of causes.
/// `said`: by the log, by channel. `inflation`: of the noise, by channel; all 1 where references are believed wholly.
[[nodiscard]] Usual usual_shapes(const Design& design, const std::vector<BlockSum>& said, const Knowledge& knowledge,
                                 const std::vector<double>& inflation);

/// From references; with none, only what is never known (start SOC, spread of cells) is left free.
[[nodiscard]] Usual usual_discrepancy(const Design& design, const Score& score,
                                      const std::vector<Reference>& references, const Knowledge& knowledge,
                                      const std::vector<double>& inflation);

/// A reference judged by the others as if it were the log, in one channel or (-1) in all.
[[nodiscard]] Remaining reference_by_the_others(const Design& design, const Knowledge& knowledge, std::size_t reference,
                                                const std::vector<double>& inflation, int channel = -1);

[[nodiscard]] Remaining remaining(const BlockSum& sum, const Usual& usual);

}  // namespace voltlap::plant
