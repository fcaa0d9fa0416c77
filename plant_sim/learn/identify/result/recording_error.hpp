// SPDX-License-Identifier: Apache-2.0
// How far the model is from the recordings, over the rows that count: those that the fit took, not those that no
// circuit follows (an open contactor, a glitch).
#pragma once
#include <utility>
#include <vector>

#include "learn/identify/cell_identification.hpp"

namespace voltlap::plant {

/// Weighted by time; over the rows that count, and RMS over all rows.
struct RecordingError {
  double rms_v = 0.0, largest_v = 0.0, all_rms_v = 0.0;
  double most_v = 0.0;  ///< 99.9 % of the time lies within
};

/// Errors with their weights, by what one of them is: the size that all but a thousandth of the weight stays below.
[[nodiscard]] double most_of(std::vector<std::pair<double, double>> size_and_weight);

[[nodiscard]] bool counts(const RecordingResult& file, Eigen::Index row);
[[nodiscard]] RecordingError error_of(const RecordingResult& file);
/// Of all recordings together.
[[nodiscard]] RecordingError error_of(const CellIdentification& identified);

}  // namespace voltlap::plant
