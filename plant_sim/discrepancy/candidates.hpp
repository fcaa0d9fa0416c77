// SPDX-License-Identifier: Apache-2.0
// Everything that can be named (and the shapes that cannot) for one log, each with its rows in one system
// (information A, score a): the part of A that acts on everything, and the part that acts on members of groups.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/usual.hpp"

namespace voltlap::plant {

struct Candidate {
  int cause = -1;                      ///< -1: an anonymous shape
  std::size_t form = 0;
  Balance balance = Balance::kVoltage;
  std::string channel;                 ///< role name, or empty
  std::vector<std::size_t> parameters; ///< of the cause, one a column
  std::vector<Eigen::Index> rows;      ///< in the system
  int group = -1;
  std::vector<Eigen::Index> members;   ///< of the group
  std::vector<Eigen::Index> shapes;    ///< of the group, one a column
  std::vector<int> signs;              ///< by column: 1 or -1 where it can have one sign only, else 0; or empty
  bool of_all_cells = false;           ///< acts on the voltage or the charge that all cells share
  double trials = 1.0;                 ///< forms and members that were looked at to find this one
};

/// For each local form the member where it explains most, as columns with their effect on the means appended to the
/// design. `scores` are the group scores of the design.
[[nodiscard]] std::vector<Candidate> local_candidates(Design& design, const std::vector<Cause>& causes,
                                                      const std::vector<GroupScore>& scores, const Usual& usual);

/// What an effect can be in one channel: the residual is the effect and what is usual, so that it has at most the
/// length of both together, in any norm: x' gram x <= most.
struct Bound {
  Eigen::MatrixXd gram;
  double most;
};

struct System {
  std::vector<Candidate> candidates;
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
  Eigen::VectorXd prior_variance;  ///< of every row, typical sizes squared
  std::vector<Bound> bounds;       ///< none without references: what is usual is not known then
};

/// The sum over all blocks when `use` is empty; group parts then too, else only their share.
[[nodiscard]] System system_of(const Design& design, const std::vector<Candidate>& locals, const Score& score,
                               const Usual& usual, const std::vector<Cause>& causes, const std::vector<bool>& use = {});

/// Group scores alone, before local columns are known.
[[nodiscard]] std::vector<GroupScore> group_scores(const Design& design, const NoiseModel& noise);

}  // namespace voltlap::plant
