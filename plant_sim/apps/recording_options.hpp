// SPDX-License-Identifier: Apache-2.0
// The flags that say how recordings of cells are read, the same for every command that takes some.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/map_finding.hpp"
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

struct RecordingOptions {
  std::vector<std::string> files;
  std::vector<std::string> maps;
  MapFinding finding;
  int cells_in_series = 1, cells_in_parallel = 1;

  /// Adds `data`, or the flag `--data` that is called so in `name`, and the flags of how it is read.
  CLI::Option* add(CLI::App& command, const std::string& name = "data");

  /// The map of each file; none without --map, --dbc and --write-map. One map is that of all files, of several each
  /// holds for the files after it.
  [[nodiscard]] std::vector<std::optional<RoleMap>> role_maps(const DataFolder& data) const;
  /// The first map, for a table that stands beside the files.
  [[nodiscard]] std::optional<RoleMap> first_map(const DataFolder& data) const;
  [[nodiscard]] LogOptions whole() const { return {-1e300, 1e300, cells_in_series, cells_in_parallel}; }

 private:
  CLI::App* command_ = nullptr;
  CLI::Option* data_ = nullptr;
};

}  // namespace voltlap::plant
