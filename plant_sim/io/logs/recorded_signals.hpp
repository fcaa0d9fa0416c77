// SPDX-License-Identifier: Apache-2.0
// Everything that a recording holds, before anybody has said what it is: the columns of a table, or the signals of
// a CAN recording that a DBC file knows.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/logs/role_source.hpp"
#include "io/table/unit_name.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {

struct RecordedSignal {
  RoleSource source;              ///< as a role map would name it; scale and unit are those of `unit`
  std::string label;              ///< the column's or the signal's name as it is written
  std::optional<NamedUnit> unit;  ///< as the file gives it
  std::vector<double> time_s;     ///< of its frames; a column has a value in every row and no times
  std::vector<double> value;      ///< as recorded; NaN for none

  /// For people: column "Strom", or 0x1DB LB_Current.
  [[nodiscard]] std::string described() const;
};

struct RecordedSignals {
  std::string path;
  bool is_can = false;
  std::vector<RecordedSignal> signals;  ///< only those with numbers
};

[[nodiscard]] RecordedSignals signals_of(const MeasuredTable& table);

/// Every signal of the DBC files that occurs among the first frames (a million); a frame that two files have
/// is the first one's. Paths of the files are made absolute, so that a map that names them can lie anywhere. Throws
/// InputError for files that cannot be read, and when they know no frame of the recording.
[[nodiscard]] RecordedSignals signals_of(const std::string& can_recording,
                                         const std::vector<std::string>& dbc_files);

}  // namespace voltlap::plant
