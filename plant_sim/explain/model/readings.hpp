// SPDX-License-Identifier: Apache-2.0
// Each reading at its own time. The model runs on the rows of the current; a reading is held against the model
// between the two rows that it lies between, and readings are averaged over bins. What the model predicts, and what
// a cause would change of it, go through the same mean, so that no delay is made.
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "discrepancy/recording.hpp"

namespace voltlap::explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Means over equal bins. Of several sensors every one counts the same, and a bin counts only where all of them
/// were read (those that the whole log has).
class Reader {
 public:
  /// Readings of these roles, each once, at the time it was read.
  static Reader of_roles(const plant::Recording& log, const std::vector<std::string>& roles, double bin_s);
  /// Every row where `by_row` has a value, as if it was read there.
  static Reader of_rows(const plant::Recording& log, const VectorXd& by_row, double bin_s);

  [[nodiscard]] Index size() const { return time_s_.size(); }
  /// Mean time of the bin's readings.
  [[nodiscard]] const VectorXd& time_s() const { return time_s_; }
  /// Mean of what was read.
  [[nodiscard]] const VectorXd& values() const { return values_; }
  /// Mean of a quantity of the rows at the same times.
  [[nodiscard]] VectorXd of(const VectorXd& by_row) const;
  /// By bin of this reader the mean of another reader's, NaN where that has none.
  [[nodiscard]] VectorXd matched(const Reader& other, const VectorXd& by_bin_of_other) const;

 private:
  struct Reading {
    Index row, bin;       ///< between `row - 1` and `row`
    double part, weight;  ///< of the way
  };
  void keep_whole_bins(std::vector<Reading> all, const std::vector<double>& read, const std::vector<int>& sensor,
                       std::size_t sensors);
  std::vector<Reading> readings_;
  std::vector<Index> slot_;  ///< number of the equal bin behind each kept one
  VectorXd time_s_, values_;
};

/// Usual time between two readings of a role [s].
[[nodiscard]] double usual_interval_s(const plant::Recording& log, const std::string& role);

}  // namespace voltlap::explain
