// SPDX-License-Identifier: Apache-2.0
// One recording of a battery as signals: seconds, amperes (discharge positive), volts of one cell, degC.
#pragma once
#include <string>
#include <vector>

#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

/// How the current runs between two rows. Testers write a row at the end of an interval, loggers at its beginning.
enum class CurrentHold {
  kPrevious,  ///< the current of a row holds until the next row
  kNext,      ///< the current of a row has held since the row before
  kLinear,    ///< straight from row to row
};
[[nodiscard]] const char* name_of(CurrentHold hold);

struct CellLog {
  std::string path;
  std::vector<double> time_s;         ///< strictly increasing
  std::vector<double> current_a;      ///< discharge positive, of one cell-file cell
  std::vector<double> voltage_v;      ///< of one cell; NaN where the recording has none
  std::vector<double> temperature_c;  ///< empty when not recorded
  std::vector<double> ambient_c;      ///< empty when not recorded
  std::vector<double> charge_ah;      ///< the recorder's own counter, discharge positive; empty when there is none
  std::vector<bool> gap;             ///< [row] the interval before this row is not recorded: its current is unknown
  std::vector<std::string> repairs;  ///< what was mended or left out, in words, for the report
  std::string map;                   ///< where the roles came from

  [[nodiscard]] std::size_t rows() const { return time_s.size(); }
};

struct LogOptions {
  double window_begin_s = -1e300, window_end_s = 1e300;  ///< in the recording's own time
  int cells_in_series = 1, cells_in_parallel = 1;        ///< to come from a pack to one cell
};

/// Reads a table or a CAN recording by its map (see role_map_for_recording for none) and mends what can be mended,
/// each repair in words. Throws InputError for a table without usable rows, for a current whose declared sign the
/// voltage contradicts, and for voltages that are those of no cell.
[[nodiscard]] CellLog read_cell_log(const std::string& path, const RoleMap* map, const DataFolder& data,
                                    const LogOptions& options = {});

/// The same from a table that is in memory already.
[[nodiscard]] CellLog cell_log_of(const MeasuredTable& table, const RoleMap& map, const LogOptions& options);

/// The same from a recording whose roles have rates of their own (CAN, several files): a row for each sample of
/// current or voltage, the current held from its last sample, a voltage only in its own row.
[[nodiscard]] CellLog cell_log_of(const DriveLog& drive, const LogOptions& options);

/// Charge drawn since the first row [Ah], row by row; gaps are bridged by the counter, or by nothing.
[[nodiscard]] std::vector<double> charge_drawn_ah(const CellLog& log, CurrentHold hold);

/// How well the counter tells the holds apart: rms of counter minus integral [Ah] for each hold, row by row.
/// Empty when there is no counter, or it is too coarse to tell.
struct HoldEvidence {
  CurrentHold hold;
  double rms_ah[3];  ///< by CurrentHold
};
[[nodiscard]] std::vector<HoldEvidence> hold_from_counter(const CellLog& log);

}  // namespace voltlap::plant
