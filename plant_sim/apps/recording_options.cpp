// SPDX-License-Identifier: Apache-2.0
#include "apps/recording_options.hpp"

#include "apps/flag_checks.hpp"

namespace voltlap::plant {

void RecordingOptions::add(CLI::App& command) {
  command.add_option("data", files, "Tables of time, current and voltage; CSV, also gzipped")->required();
  command.add_option("--map", map,
                     "Role map: name or path; default: by column names, or a shipped map by its header");
  command.add_option("--cells-in-series", cells_in_series, "Cells in series behind the recorded voltage")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  command.add_option("--cells-in-parallel", cells_in_parallel, "Cells in parallel behind the recorded current")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
}

std::optional<RoleMap> RecordingOptions::role_map(const DataFolder& data) const {
  if (map.empty()) return std::nullopt;
  return load_role_map(data.find("maps", map, "--map"));
}

}  // namespace voltlap::plant
