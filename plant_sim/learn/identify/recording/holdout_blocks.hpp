// SPDX-License-Identifier: Apache-2.0
// A run in blocks, so that a part can be kept back from a fit and predicted.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// Rows first to last (exclusive).
struct Block {
  Eigen::Index first, last;
};

/// The first `window_s` from each onset of current after a rest of at least 30 s.
[[nodiscard]] std::vector<Block> pulse_windows(const MeasuredRun& run, double window_s);
/// Blocks of equal time from the beginning.
[[nodiscard]] std::vector<Block> time_blocks(const MeasuredRun& run, double seconds);

/// The same run with the rows of every second block (from block `first`) given no weight.
[[nodiscard]] MeasuredRun without_every_second(const MeasuredRun& run, const std::vector<Block>& blocks,
                                               std::size_t first);

/// Error less its value just before each block: what the block itself adds, without the drift of the OCV.
[[nodiscard]] Eigen::VectorXd since_onset(const Eigen::VectorXd& error, const std::vector<Block>& blocks);

struct BlockScore {
  struct Part {
    double rms, seconds;
  };
  std::vector<Part> parts;            ///< block by block
  [[nodiscard]] double mean() const;  ///< of the blocks' rms, weighted by time: one bad block does not decide alone
};
/// Standard error of the mean difference of two scores of the same blocks.
[[nodiscard]] double standard_error_of_difference(const BlockScore& a, const BlockScore& b);
/// Score of every second block (from `first`).
[[nodiscard]] BlockScore score_every_second(const MeasuredRun& run, const Eigen::VectorXd& error,
                                            const std::vector<Block>& blocks, std::size_t first);

}  // namespace voltlap::plant
