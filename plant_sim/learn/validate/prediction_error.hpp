// SPDX-License-Identifier: Apache-2.0
// A cell file against recordings that it never saw: error over time, and what in the recording itself is amiss.
#pragma once
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "learn/identify/recording/measured_run.hpp"
#include "learn/validate/cell_response.hpp"

namespace voltlap::plant {

struct ValidationOptions {
  double temperature_c = 25.0;    ///< where a recording has none
  bool temperature_told = false;  ///< by whoever has the cell, not assumed
};

/// Squared error, weighted by time, so that sums over files and bands stay right.
struct ErrorSum {
  double square_v2_s = 0.0, weight_s = 0.0;
  [[nodiscard]] double rms_v() const { return weight_s > 0.0 ? std::sqrt(square_v2_s / weight_s) : 0.0; }
  ErrorSum& operator+=(const ErrorSum& other) {
    square_v2_s += other.square_v2_s;
    weight_s += other.weight_s;
    return *this;
  }
};

/// A recording with its SOC, its hold and the rows that count: whatever is tried on it later is tried on the same.
struct PlacedRecording {
  const CellLog* log;
  RunOptions options;
  std::string hold_from;
  RecordedTemperature temperature;
  MeasuredRun run;
  std::vector<bool> counts;  ///< discharge strokes
  int strokes = 0;
};

/// Throws InputError when nothing was drawn from the cell.
[[nodiscard]] PlacedRecording place_recording(const CellModel& model, const CellLog& log,
                                              const ValidationOptions& options);

/// What is tried on a placed recording instead of what the cell file says.
struct RunChange {
  double capacity_ah = 0.0;  ///< 0: as placed
  double soc_share = 0.0;    ///< of the SOC at the first stroke, added to every SOC
};
[[nodiscard]] MeasuredRun changed_run(const PlacedRecording& placed, const RunChange& change);
[[nodiscard]] ErrorSum error_of(const CellModel& model, const PlacedRecording& placed,
                                const RunChange& change = {});

/// Capacity at which the recording is met best (reference study, 2016, sections 7.2.3 and 7.3.2).
struct CapacityAdjustment {
  double by_ah = 0.0, rms_v = 0.0;
  bool at_end = false;  ///< of the search, +- 15 %: the recording does not tell
};
[[nodiscard]] CapacityAdjustment adjust_capacity(const CellModel& model, const PlacedRecording& placed);

enum class TemperatureKind { kHeld, kFree, kNotRecorded };

/// The temperature that the cell file's thermal model makes of a recording; its lookups use it where none was recorded.
struct SimulatedTemperature {
  double start_c = 25.0, highest_c = 25.0;
  std::string start_from;  ///< recorded, --temperature, its ambient, assumed
};

struct SocBand {
  double low, high;
  ErrorSum error;
};

struct FileValidation {
  std::string file;
  CurrentHold hold = CurrentHold::kNext;
  std::string hold_from;
  std::vector<std::string> repairs;
  bool constant_current = false;
  TemperatureKind temperature = TemperatureKind::kNotRecorded;
  double rms_v = 0.0;  ///< over discharge strokes, weighted by time, as all of the next
  double rms_v_above_10_soc = 0.0;
  double bias_v = 0.0;  ///< model minus recording
  double max_error_v = 0.0;
  ErrorSum error;
  std::array<SocBand, 5> bands{{{0.8, 9.0, {}}, {0.5, 0.8, {}}, {0.2, 0.5, {}}, {0.1, 0.2, {}}, {-9.0, 0.1, {}}}};
  std::optional<double> temperature_rms_c;  ///< empty where no temperature was recorded
  SimulatedTemperature simulated;           ///< what the model made of it
  double ah = 0.0;                          ///< drawn in the strokes
  double soc_start = 1.0;                   ///< of the first stroke
  std::string soc_start_from;               ///< full charge, rest, fitted
  int strokes = 0;
  double voltage_lag_s = 0.0;   ///< by which the recorded voltage trails its current; 0: none found
  double rms_v_with_lag = 0.0;  ///< with that lag put on the model's voltage
  CapacityAdjustment capacity;
};

/// Simulates the cell's tables through a recording. A discharge stroke runs from the first current drawn after a
/// full charge (or the beginning) to the last before the next charge; rests of more than a minute in it do not
/// count.
[[nodiscard]] FileValidation validate(const CellModel& model, const PlacedRecording& placed,
                                      const CellResponse& response);

/// All of it in one call.
[[nodiscard]] FileValidation validate(const CellParameters& cell, const CellLog& log,
                                      const ValidationOptions& options);

}  // namespace voltlap::plant
