// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/holdout_blocks.hpp"

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

using Eigen::Index;

std::vector<Block> pulse_windows(const MeasuredRun& run, double window_s) {
  constexpr double kRest = 30.0;
  VOLTLAP_DEMAND(run.rows() > 0 && window_s > 0.0);
  const double quiet = 0.01 * run.current_a.cwiseAbs().maxCoeff();
  std::vector<Block> blocks;
  double rested = 0.0, begun = -1e300;
  for (Index row = 1; row < run.rows(); ++row) {
    const bool resting = std::abs(run.current_a(row)) <= quiet;
    if (!resting && rested >= kRest) {
      blocks.push_back({row, row});
      begun = run.time_s(row);
    }
    if (!blocks.empty() && run.time_s(row) - begun < window_s) {
      blocks.back().last = row + 1;
      // A state that is free within the window would have to be known without its rows.
      if (run.is_reset(row)) {
        blocks.pop_back();
        begun = -1e300;
      }
    }
    rested = resting && !run.is_reset(row) ? rested + run.dt_s(row) : 0.0;
  }
  return blocks;
}

std::vector<Block> time_blocks(const MeasuredRun& run, double seconds) {
  VOLTLAP_DEMAND(run.rows() > 0 && seconds > 0.0);
  std::vector<Block> blocks;
  Index first = 0;
  for (Index row = 0; row < run.rows(); ++row) {
    const auto number = [&](Index at) { return std::floor((run.time_s(at) - run.time_s(0)) / seconds); };
    if (row > 0 && number(row) > number(row - 1)) {
      // A gap may skip numbers: the parity of the time, not of the count, decides, so blocks may be empty.
      for (double skip = number(row - 1); skip < number(row); skip += 1.0) {
        blocks.push_back({first, row});
        first = row;
      }
    }
  }
  blocks.push_back({first, run.rows()});
  return blocks;
}

MeasuredRun without_every_second(const MeasuredRun& run, const std::vector<Block>& blocks, std::size_t first) {
  VOLTLAP_DEMAND(blocks.empty() || blocks.back().last <= run.rows());
  MeasuredRun out = run;
  for (std::size_t b = first; b < blocks.size(); b += 2) {
    out.weight_s.segment(blocks[b].first, blocks[b].last - blocks[b].first).setZero();
  }
  return out;
}

Eigen::VectorXd since_onset(const Eigen::VectorXd& error, const std::vector<Block>& blocks) {
  VOLTLAP_DEMAND(blocks.empty() || blocks.back().last <= error.size());
  Eigen::VectorXd out = error;
  for (const Block& block : blocks) {
    if (block.first > 0) out.segment(block.first, block.last - block.first).array() -= error(block.first - 1);
  }
  return out;
}

double BlockScore::mean() const {
  double sum = 0.0, seconds = 0.0;
  for (const Part& part : parts) {
    sum += part.rms * part.seconds;
    seconds += part.seconds;
  }
  return seconds > 0.0 ? sum / seconds : 0.0;
}

double standard_error_of_difference(const BlockScore& a, const BlockScore& b) {
  VOLTLAP_DEMAND(a.parts.size() == b.parts.size());
  const double mean = a.mean() - b.mean(), count = static_cast<double>(a.parts.size());
  double scatter = 0.0, seconds = 0.0;
  for (std::size_t k = 0; k < a.parts.size(); ++k) {
    const double off = (a.parts[k].rms - b.parts[k].rms - mean) * a.parts[k].seconds;
    scatter += off * off;
    seconds += a.parts[k].seconds;
  }
  return count > 1.0 ? std::sqrt(scatter * count / (count - 1.0)) / seconds : std::abs(mean);
}

BlockScore score_every_second(const MeasuredRun& run, const Eigen::VectorXd& error, const std::vector<Block>& blocks,
                              std::size_t first) {
  VOLTLAP_DEMAND(error.size() == run.rows() && (blocks.empty() || blocks.back().last <= run.rows()));
  BlockScore score;
  for (std::size_t b = first; b < blocks.size(); b += 2) {
    const Index n = blocks[b].last - blocks[b].first;
    const auto w = run.weight_s.segment(blocks[b].first, n).array();
    const double seconds = w.sum();
    if (seconds <= 0.0) continue;
    score.parts.push_back(
        {std::sqrt((w * error.segment(blocks[b].first, n).array().square()).sum() / seconds), seconds});
  }
  return score;
}

}  // namespace voltlap::plant
