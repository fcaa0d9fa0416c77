// SPDX-License-Identifier: Apache-2.0
// The flags that say how recordings of cells are read, the same for every command that takes some.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "logs/cell_log.hpp"

namespace voltlap::plant {

struct RecordingOptions {
  std::vector<std::string> files;
  std::string map;
  int cells_in_series = 1, cells_in_parallel = 1;

  /// Adds `data` and the flags.
  void add(CLI::App& command);

  /// The map that --map names; none without it.
  [[nodiscard]] std::optional<RoleMap> role_map(const DataFolder& data) const;
  [[nodiscard]] LogOptions whole() const { return {-1e300, 1e300, cells_in_series, cells_in_parallel}; }
};

}  // namespace voltlap::plant
