// SPDX-License-Identifier: Apache-2.0
// How a fitted thermal model does beside that of the cell file, and on what it was not fitted on.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "learn/validate/thermal_fit.hpp"

namespace voltlap::plant {

/// Temperature of the surface by a model, from the first recorded value on.
[[nodiscard]] std::vector<double> thermal_response(const ThermalModel& model, const ThermalRecording& recording);
/// Weighted by time, over rows from `from_row` on; empty where no temperature was recorded there.
[[nodiscard]] std::optional<double> thermal_rms_c(const ThermalModel& model, const ThermalRecording& recording,
                                                  std::size_t from_row = 0);

struct ThermalValidation {
  ThermalModel fitted;  ///< on everything
  struct File {
    std::string file;
    std::optional<double> rms_as_given_c, rms_fitted_c;  ///< in the air that the fit found where none was recorded
    AirFrom air;
    double air_c, air_ci95_k;
    std::optional<double> rms_held_out_c;  ///< empty: what is left does not tell the model
  };
  std::vector<File> files;
};
/// Each recording is held out from a fit of the others; of a single one the second half from a fit of its first.
[[nodiscard]] ThermalValidation validate_thermal(const CellParameters& cell,
                                                 const std::vector<ThermalRecording>& recordings);

/// What a cell file takes over: lines of TOML with the fitted numbers per kg and m2 of the file, to six digits.
[[nodiscard]] std::vector<std::string> cell_file_lines(const CellParameters& cell, const ThermalModel& model);

}  // namespace voltlap::plant
