// SPDX-License-Identifier: Apache-2.0
// What an identification says of one recording once there is a model: its span, and how the model follows it.
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// A recording and the model's answer to it, row by row.
struct RecordingTrace {
  Eigen::VectorXd time_s, current_a, voltage_v, error_v, soc, weight_s;  ///< error: model less recorded
};

/// RMS of the cell file and of the fit, [V]: of all rows and of those that the fit took.
struct ReadBack {
  double fit_rms_v = 0.0, used_rms_v = 0.0, fit_used_rms_v = 0.0;
};

/// What was found of one recording, before the fit and by it.
struct RecordingResult {
  std::string path, map;
  std::vector<std::string> repairs;
  CurrentHold hold = CurrentHold::kNext;
  std::string hold_from;  ///< counter, voltage, like the first file
  SocAnchor anchor;
  double soc_low = 0.0, soc_high = 1.0, duration_s = 0.0;
  double coldest_c = 25.0, warmest_c = 25.0;  ///< recorded or told
  double voltage_low_v = 0.0, voltage_high_v = 0.0;  ///< of the rows that the model follows
  Eigen::Index rows = 0;
  Eigen::VectorXd states_v;  ///< of the fit: voltages of the branches where the recording does not begin at rest
  double rms_v = 0.0, rms_pulses_v = 0.0;  ///< all rows; from the full charge on
  std::vector<bool> used{};                ///< [row of the trace] what the fit took; empty: all rows
  /// Empty: rms_v, rms_pulses_v and trace are of the fit; else of the cell file that was read back.
  std::optional<ReadBack> read_back{};
  RecordingTrace trace{};
};

/// `error_v`: model less recorded, at every row of `whole`.
[[nodiscard]] RecordingResult recording_result(const PreparedLog& prepared, const MeasuredRun& whole,
                                               const Eigen::VectorXd& error_v);

}  // namespace voltlap::plant
