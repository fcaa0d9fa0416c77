// SPDX-License-Identifier: Apache-2.0
#include "apps/recording_options.hpp"

#include <algorithm>

#include "apps/flag_checks.hpp"

namespace voltlap::plant {

CLI::Option* RecordingOptions::add(CLI::App& command, const std::string& name) {
  command_ = &command;
  data_ = command.add_option(
      name, files, "Recordings of time, current and voltage: CSV, also gzipped, or a CAN log with its --map or --dbc");
  command
      .add_option("--map", maps,
                  "Role map: name or path; given again, of the files after it; default: by column names, or a shipped "
                  "map by its header")
      ->allow_extra_args(false);
  finding.add(command);
  command.add_option("--cells-in-series", cells_in_series, "Cells in series behind the recorded voltage")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  command.add_option("--cells-in-parallel", cells_in_parallel, "Cells in parallel behind the recorded current")
      ->check(whole_number(1, 1000))
      ->capture_default_str();
  return data_;
}

std::vector<std::optional<RoleMap>> RecordingOptions::role_maps(const DataFolder& data) const {
  std::vector<std::optional<RoleMap>> out;
  std::optional<RoleMap> next;
  if (maps.size() == 1) next = first_map(data);
  std::size_t given = 0;
  for (const CLI::Option* option : command_->parse_order()) {
    if (option->get_name() == "--map" && maps.size() > 1)
      next = load_role_map(data.find("maps", maps.at(given++), "--map"));
    if (option == data_) out.push_back(next);
  }
  finding.check_needed(std::all_of(out.begin(), out.end(), [](const auto& map) { return map.has_value(); }));
  bool written = false;
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (out[k]) continue;
    out[k] = written ? finding.find_only(files.at(k)) : finding.find(files.at(k));
    written = true;
  }
  return out;
}

std::optional<RoleMap> RecordingOptions::first_map(const DataFolder& data) const {
  if (maps.empty()) return std::nullopt;
  return load_role_map(data.find("maps", maps.front(), "--map"));
}

}  // namespace voltlap::plant
