// SPDX-License-Identifier: Apache-2.0
// A recording on the command line, with the DBC files that it is decoded with.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/can/dbc_set.hpp"

namespace voltlap::plant {

class RecordingInput {
 public:
  /// Adds the recording and --dbc, --map.
  void add(CLI::App& command);

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Opens the recording; what breaks off is kept up to there. Where it has no stamps, the intervals of the map count,
  /// else those of the DBC files. Remote frames are left out and counted but for who asks for them. Throws InputError
  /// for a table.
  [[nodiscard]] std::unique_ptr<CanRecording> open(const DbcSet& dbc, bool keep_remote = false) const;
  /// Throws InputError when a result would take the place of the recording.
  void refuse_as_output(const std::string& out) const;
  /// The files of --dbc, and those that the map names.
  [[nodiscard]] DbcSet dbc(const DataFolder& data);
  /// The same; throws InputError when there is none.
  [[nodiscard]] DbcSet needed_dbc(const DataFolder& data);

 private:
  std::string path_, map_;
  std::vector<std::string> dbc_;
  std::map<std::uint32_t, double> period_s_;  ///< that the map gives
};

/// What a person must know of a recording that was read to its end: what was left out and mended, how the clock was
/// read, where it breaks off. Nothing when there is nothing.
[[nodiscard]] std::string remarks_text(const std::string& path, const CanSummary& summary);

}  // namespace voltlap::plant
