// SPDX-License-Identifier: Apache-2.0
// The thermal part of a cell from recorded temperatures, with the heat that the circuit's resistances make
// (reference study, 2016, section 7.5):
//
//   C dT/dt = P - G (T - T_ambient),   C = m cp [J/K],   G = h A [W/K]        Eq. 7.7, exact over an interval
//   L dT_s/dt = T - T_s                the surface, where a thermistor sits, follows the cell
//
// Seen from its surface a cell with a core (Lin et al., J. Power Sources 257, 2014) is the same two poles and no zero.
// For a given rate a = G / C and lag L the temperature is linear in 1/C and in the start temperatures: those by linear
// least squares, a and L by a search. A lag that could as well be none is none. An ambient that was not recorded is the
// temperature at which the cell began. Reversible (entropic) heat is not in it.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "learn/validate/cell_response.hpp"

namespace voltlap::plant {

/// One recording as the thermal fit sees it.
struct ThermalRecording {
  std::string file;
  std::vector<double> dt_s, heat_w;   ///< of the interval that ends at the row; dt 0: nothing known before it
  std::vector<double> temperature_c;  ///< NaN where not recorded
  std::vector<double> ambient_c;      ///< at every row
  bool ambient_assumed = false;       ///< it was not recorded
};
[[nodiscard]] ThermalRecording thermal_recording(const std::string& file, const MeasuredRun& run,
                                                 const CellResponse& response,
                                                 const RecordedTemperature& temperature);

struct ThermalModel {
  double capacity_j_per_k = 0.0, conductance_w_per_k = 0.0;
  double capacity_ci95 = 0.0, conductance_ci95 = 0.0;  ///< half widths, relative; residuals that stay count once
  double surface_lag_s = 0.0, surface_lag_ci95_s = 0.0;  ///< L and its half width
};

/// Throws InputError when the temperatures do not rise enough above their steps to tell a heat capacity.
[[nodiscard]] ThermalModel fit_thermal(const std::vector<ThermalRecording>& recordings);

/// Temperature by a model, from the first recorded value on.
[[nodiscard]] std::vector<double> thermal_response(const ThermalModel& model, const ThermalRecording& recording);
/// Weighted by time, over rows from `from_row` on.
[[nodiscard]] double thermal_rms_c(const ThermalModel& model, const ThermalRecording& recording,
                                   std::size_t from_row = 0);

/// How a fitted model does on what it was not fitted on: each recording by a fit of the others; a single one's
/// second half by a fit of its first.
struct ThermalValidation {
  ThermalModel fitted;  ///< on everything
  struct File {
    std::string file;
    double rms_as_given_c, rms_fitted_c;
    bool ambient_assumed;
    std::optional<double> rms_held_out_c;  ///< empty: what is left does not tell the model
  };
  std::vector<File> files;
};
[[nodiscard]] ThermalValidation validate_thermal(const CellParameters& cell,
                                                 const std::vector<ThermalRecording>& recordings);

}  // namespace voltlap::plant
