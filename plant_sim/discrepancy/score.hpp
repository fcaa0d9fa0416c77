// SPDX-License-Identifier: Apache-2.0
// A log in the whitened domain, reduced to what every later step needs: for each channel and block of time the Gram
// matrix of the signatures, their products with the residual, and its energy. No step after this sees samples.
#pragma once
#include <Eigen/Dense>
#include <map>
#include <string>
#include <vector>

#include "discrepancy/design.hpp"
#include "discrepancy/mixed_model.hpp"
#include "discrepancy/noise.hpp"

namespace voltlap::plant {

/// Noise by channel name, and by stem for the members of a group.
using NoiseModel = std::map<std::string, Noise>;

struct BlockSum {
  Eigen::MatrixXd gram;
  Eigen::VectorXd score;
  double energy = 0.0, rows = 0.0;
  void add(const BlockSum& other, double weight = 1.0);
};
[[nodiscard]] BlockSum empty_sum(Eigen::Index columns);

struct GroupScore {
  Eigen::MatrixXd gram;   ///< of the shapes
  Eigen::MatrixXd score;  ///< [shape][member]
  Eigen::VectorXd energy; ///< [member]
  double rows = 0.0;
};

struct Score {
  std::vector<std::vector<BlockSum>> channels;  ///< [channel][block]
  std::vector<GroupScore> groups;
  [[nodiscard]] Eigen::Index columns() const { return channels.front().front().score.size(); }
  /// Sum over the blocks with `use`(block), each channel over its inflation (1 where `inflation` is empty).
  [[nodiscard]] BlockSum sum(const std::vector<double>& inflation, const std::vector<bool>& use = {}) const;
  [[nodiscard]] std::size_t blocks() const { return channels.front().size(); }
};

/// Sums over all blocks, by channel.
[[nodiscard]] std::vector<BlockSum> channel_totals(const Score& score);

inline constexpr double kBlock = 60.0;  // s

/// Block of every row.
[[nodiscard]] std::vector<std::size_t> block_of_rows(const Eigen::VectorXd& time_s);

[[nodiscard]] Score score_of(const Design& design, const NoiseModel& noise);

/// What is expected of these columns in sound logs.
[[nodiscard]] ColumnPrior prior_of(const Design& design, const std::vector<Eigen::Index>& columns);

/// Ohms by which noise of the current comes into a channel's model side, by row; empty: none.
[[nodiscard]] Eigen::VectorXd ohm_of(const Design& design, std::size_t channel);

/// Noise of what is left when the logs' common and own amounts of the shapes without a name are taken away. One log
/// alone: of what no column explains, its slow part enlarged by what the many columns took of it.
[[nodiscard]] NoiseModel noise_of(const std::vector<const Design*>& designs);

}  // namespace voltlap::plant
