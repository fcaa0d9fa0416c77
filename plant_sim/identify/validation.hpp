// SPDX-License-Identifier: Apache-2.0
// A cell file against recordings that it never saw: error over time, and what in the recording itself is amiss.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "identify/test_run.hpp"

namespace voltlap::plant {

struct FileValidation {
  std::string file;
  CurrentHold hold = CurrentHold::kNext;
  std::string hold_from;
  std::vector<std::string> repairs;
  double rms_v = 0.0;  ///< over discharge strokes, weighted by time, as all of the next
  double rms_v_above_10_soc = 0.0;
  double bias_v = 0.0;  ///< model minus recording
  double max_error_v = 0.0;
  std::optional<double> temperature_rms_c;  ///< empty without a temperature column
  double ah = 0.0;                          ///< drawn in the strokes
  double soc_start = 1.0;                   ///< of the first stroke
  std::string soc_start_from;               ///< full charge, rest, fitted
  int strokes = 0;
  double voltage_lag_s = 0.0;   ///< by which the recorded voltage trails its current; 0: none found
  double rms_v_with_lag = 0.0;  ///< with that lag put on the model's voltage
};

struct ValidationOptions {
  double temperature_c = 25.0;  ///< where a recording has none
};

/// Simulates the cell's tables through a recording. A discharge stroke runs from the first current drawn after a
/// full charge (or the beginning) to the last before the next charge; rests of more than a minute in it do not
/// count.
[[nodiscard]] FileValidation validate(const CellParameters& cell, const CellLog& log,
                                      const ValidationOptions& options);

}  // namespace voltlap::plant
