// SPDX-License-Identifier: Apache-2.0
// A recording made ready for a fit: SOC by charge counting, intervals with their current, weights by time.
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

struct MeasuredRun {
  std::string name;
  Eigen::VectorXd time_s, current_a, voltage_v, soc;
  Eigen::VectorXd dt_s, current_begin_a, current_end_a;  ///< of the interval that ends at the row
  Eigen::VectorXd weight_s;                              ///< time that the row stands for, capped; 0: not used
  Eigen::VectorXd temperature_c;                         ///< recorded, or what is known of it
  std::vector<bool> reset;           ///< branch states are free at this row (first row, after gaps)
  std::vector<bool> at_rest_before;  ///< with `reset`: branches are known to be at rest (true) or unknown

  [[nodiscard]] Eigen::Index rows() const { return time_s.size(); }
  [[nodiscard]] bool is_reset(Eigen::Index row) const { return reset[static_cast<std::size_t>(row)]; }
};

/// Where SOC is known in a recording.
struct SocAnchor {
  std::size_t row = 0;
  double soc = 1.0;
  std::string from = "full charge";  ///< full charge, rest, fitted
};

/// Rows at which a charge has ended at the highest voltage, and a first row that stands there already.
[[nodiscard]] std::vector<std::size_t> full_charges(const CellLog& log);

/// Of |current| [A].
[[nodiscard]] double largest_current(const CellLog& log);

/// True where |current| is below a hundredth of the recording's largest.
[[nodiscard]] std::vector<bool> resting_rows(const CellLog& log);

struct RunOptions {
  CurrentHold hold = CurrentHold::kNext;
  double capacity_ah = 1.0;
  SocAnchor anchor;
  std::vector<std::size_t> full_rows;  ///< later full charges: SOC is 1 again at each
  double temperature_c = 25.0;  ///< of rows without a recorded one before them
  double weight_cap_s = 30.0;  ///< long intervals count no more than this
};

[[nodiscard]] MeasuredRun make_run(const CellLog& log, const RunOptions& options);

/// The same run with fewer rows: where the current is steady, neighbours become one row of their means, over at most
/// `share` of the time since the current last changed. Nothing is thrown away: the noise of a mean is that of the
/// weight it stands for. Of an exponential it takes w^2 / (24 tau^2) too much: 4e-5 with w = 3 % of tau.
[[nodiscard]] MeasuredRun averaged(const MeasuredRun& run, double share = 0.03);

/// The same run with one row for each `seconds`: means of rows that are closer, for questions that single rows do not
/// decide. Rows without a weight and the first after a gap stay by themselves.
[[nodiscard]] MeasuredRun coarsened(const MeasuredRun& run, double seconds);

/// Recordings for choices that single rows do not decide: means of a second where there are many rows.
[[nodiscard]] std::vector<MeasuredRun> coarsened_where_many(const std::vector<MeasuredRun>& runs);

/// The same run with fewer rows in its rests, none of them a mean, as the pulse and layered methods take it: a row is
/// kept when `share` of the time since the last step has passed. Exact for a current held between rows, since nothing
/// happens in between; weights are summed.
inline constexpr double kRestThinning = 0.05;
[[nodiscard]] MeasuredRun thinned(const MeasuredRun& run, double share);

}  // namespace voltlap::plant
