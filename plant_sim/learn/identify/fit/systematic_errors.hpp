// SPDX-License-Identifier: Apache-2.0
// What instruments do all day long moves the parameters and leaves no trace in the residual: an offset, a gain, rows
// that are stamped a step off. Each possible error is put into the recording at one sigma, and the fit's answer
//
//   d = -A^-1 g(recording with the error)        one Gauss-Newton step from the fit
//
// is added to the variance, d^2 for each.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/fit/full_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// Largest errors by the data sheets, taken for evenly spread: sigma is a bound over the root of three.
struct InstrumentLimits {
  double voltage_v = 0.0, voltage_gain = 0.0;
  double current_a = 0.0, current_gain = 0.0;  ///< under load
  double rest_current_a = 0.0;                 ///< at rest
};

/// What was fitted, and how its rows were made.
struct FittedRecordings {
  const std::vector<PreparedLog>& prepared;
  const std::vector<MeasuredRun>& runs;  ///< with the weights that the fit gave
  bool every_row;                        ///< no means of rows
  bool capacity_known;                   ///< SOC is not scaled by what the recordings span
};

/// Variance of each packed parameter. Where a recording's hold is an assumption, the opposite one is among the errors;
/// so is a thermometer that shows what the cell had 15 s ago.
[[nodiscard]] Eigen::VectorXd systematic_error_variance(const FittedRecordings& recordings,
                                                        const InstrumentLimits& limits, const FullFit& full);

}  // namespace voltlap::plant
