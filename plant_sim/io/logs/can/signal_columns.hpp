// SPDX-License-Identifier: Apache-2.0
// Decoded signals as raw columns of doubles in a folder, with a manifest.json: what the writers of MF4, MCAP and
// Parquet take (plant_sim/python/voltlap_logs/signal_folder.py). Written as it comes, so that the memory does not grow
// with the recording.
#pragma once
#include <string>
#include <vector>

#include "io/logs/can/signal_rows.hpp"

namespace voltlap::plant {

class SignalColumns {
 public:
  /// `folder` is there and empty. Throws OutputError when it cannot be written.
  explicit SignalColumns(std::string folder) : folder_(std::move(folder)) {}

  /// The first row sets the origin of all times.
  void add(const SignalRows::Row& row);
  /// Writes what is left and the manifest. `source` names the recording.
  void finish(const std::vector<SignalGroup>& groups, const std::string& source);

 private:
  struct Column {
    std::string file;
    std::vector<double> waiting;
  };
  struct Group {
    std::size_t rows = 0;
    std::vector<Column> columns;  ///< time first
  };
  void append(Column& column, double value);
  void flush(Column& column);

  std::string folder_;
  std::vector<Group> groups_;
  double origin_s_ = 0.0;
  bool begun_ = false;
};

}  // namespace voltlap::plant
