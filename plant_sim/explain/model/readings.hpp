// SPDX-License-Identifier: Apache-2.0
// Each reading at its own time. The model runs on the rows of the current; a reading is held against the model
// between the two rows that it lies between, and readings are averaged over bins. Where a reading is a straight
// line between two times at which a sensor passed the middle of its steps, the model is that line between its own
// values at these times: what it does in between is not contradicted by what was not seen. What the model predicts,
// and what a cause would change of it, go through the same mean, so that no delay is made.
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "explain/balances/recording.hpp"

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

  [[nodiscard]] Index size() const { return static_cast<Index>(slot_.size()); }
  /// Mean time of the bin's readings.
  [[nodiscard]] const VectorXd& time_s() const { return time_s_; }
  /// The same without what it differs by from bin to bin: steps of whole bins.
  [[nodiscard]] VectorXd even_time_s() const;
  /// Mean of what was read.
  [[nodiscard]] const VectorXd& values() const { return values_; }
  /// Mean of a quantity of the rows at the same times.
  [[nodiscard]] VectorXd of(const VectorXd& by_row) const;
  /// Leaves out the other bins.
  void keep(const std::vector<bool>& bins);
  /// By bin of this reader the mean of another reader's, NaN where that has none.
  [[nodiscard]] VectorXd matched(const Reader& other, const VectorXd& by_bin_of_other) const;

 private:
  struct Reading {
    Index row, bin;  ///< between `row - 1` and `row`
    double part;     ///< of the way
    double share;    ///< of a reading: one, or what each end of a straight line has of it
  };
  /// What a row adds to a bin. A row can be in two: then it has a second such part.
  struct Part {
    Index row, bin;
    double weight;
  };
  void keep_whole_bins(std::vector<Reading> all, const std::vector<double>& read, const std::vector<int>& sensor,
                       std::size_t sensors);
  /// Where a time lies between two rows, at or before row `from`.
  static Reading place_of(const VectorXd& time_s, Index from, double at_s);
  void put_parts(const std::vector<Reading>& readings, const std::vector<double>& weight);
  std::vector<Part> parts_;  ///< by row, and by bin; then the second ones
  std::vector<Index> slot_;  ///< number of the equal bin behind each kept one
  VectorXd time_s_, values_;
  double bin_s_ = 1.0;
};

/// Where a row has no value, that of the row before; of the first rows, of the first that has one. Nothing in their
/// place would be an effect that comes later than it does.
[[nodiscard]] VectorXd filled(VectorXd by_row);

/// Usual time between two readings of a role [s].
[[nodiscard]] double usual_interval_s(const plant::Recording& log, const std::string& role);

}  // namespace voltlap::explain
