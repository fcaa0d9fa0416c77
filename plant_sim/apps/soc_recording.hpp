// SPDX-License-Identifier: Apache-2.0
// The firmware's estimators over a recording of one cell, against the charge that was counted from a start at rest.
#pragma once
#include <string>
#include <vector>

#include "apps/soc_trial.hpp"
#include "bms/config.hpp"
#include "car/battery/cell_tables.hpp"
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

struct SocRecordingRow {
  std::string name;
  SocScore ekf, coulomb;
};

struct SocRecordingResult {
  std::string file;
  std::vector<std::string> remarks;  ///< what was mended, assumed or left out
  std::vector<SocRecordingRow> rows;
  double begin_soc = 0.0, low_soc = 1.0, high_soc = 0.0, judged_s = 0.0;  ///< low and high: while judged
  double slope_bound_points = 0.0;  ///< what 5 mV of OCV are worth where a tenth of the judged charge is flatter
};

/// From the recording's first voltage to its first gap. `otherwise_c`: the temperature [degC] of a recording without a
/// thermometer. Throws InputError for a recording without a voltage, or in which less than a tenth of the charge moves.
[[nodiscard]] SocRecordingResult run_soc_recording(const CellLog& log, const CellParameters& cell,
                                                   const bms::Config& config, double otherwise_c);

}  // namespace voltlap::plant
