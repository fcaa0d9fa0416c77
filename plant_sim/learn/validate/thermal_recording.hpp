// SPDX-License-Identifier: Apache-2.0
// A recording as the thermal fit sees it: heat of each interval, temperature, and the air around the cell.
//
//   P = P_irr + e q,   q = -I T          P_irr of the file's resistances [W]; e = dOCV/dT [V/K]; I discharge positive,
//                                        T in K (Bernardi et al., J. Electrochem. Soc. 132, 1985), that of the reading:
//                                        a kelvin off within is 0.3 % of the reversible heat
//
// Air that was not recorded is that of the cell's start when the recording begins with a rest that shows no drift; else
// it is fitted, held near the start.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "learn/validate/cell_response.hpp"

namespace voltlap::plant {

/// Where the air's temperature is from.
enum class AirFrom { kLog, kStartAfterRest, kFitted };
[[nodiscard]] std::string_view name_of(AirFrom from);

/// 1 sigma of an air that only the fit tells, about the start: 95 % within 15 K, the most that a room, a box or a day
/// differs from a cell that was put into it.
inline constexpr double kFreeAir_k = 7.5;

struct ThermalRecording {
  std::string file;
  std::vector<double> dt_s, heat_w;   ///< of the interval that ends at the row, heat without the reversible; dt 0:
                                      ///< nothing known before it
  std::vector<double> heat_per_entropy_w_k_per_v;  ///< q; empty: no current is known
  std::vector<double> temperature_c;  ///< NaN where not recorded
  std::vector<double> ambient_c;      ///< at every row; not recorded: that of the start
  AirFrom air = AirFrom::kLog;
  double air_sd_k = 0.0;  ///< of the air about the start, where it was not recorded

  /// First reading [degC]; 25 without any.
  [[nodiscard]] double start_c() const;
  [[nodiscard]] std::size_t rows() const { return dt_s.size(); }
  [[nodiscard]] double heat_per_entropy(std::size_t row) const {
    return heat_per_entropy_w_k_per_v.empty() ? 0.0 : heat_per_entropy_w_k_per_v[row];
  }
};

[[nodiscard]] ThermalRecording thermal_recording(const std::string& file, const MeasuredRun& run,
                                                 const CellResponse& response,
                                                 const RecordedTemperature& temperature);

/// Rows `first` to `last` (exclusive).
[[nodiscard]] ThermalRecording part_of(const ThermalRecording& whole, std::size_t first, std::size_t last);

}  // namespace voltlap::plant
