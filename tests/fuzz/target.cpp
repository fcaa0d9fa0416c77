// SPDX-License-Identifier: Apache-2.0
#include "fuzz/target.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

namespace voltlap::plant {
namespace {

constexpr std::size_t kText = 1 << 16, kParameters = 1 << 14, kFitted = 1 << 11;
/// A fit, which sanitizers slow down by nine.
constexpr double kFitSeconds = 20.0;

constexpr std::array<FuzzTarget, 18> kTargets{{
    {"lines", "input.txt", kText, read_lines},
    {"measured_table", "input.csv", kText, read_measured},
    {"input_table", "input.csv", kText, read_input_table},
    {"can", "input.log", kText, read_can},
    {"dbc", "input.dbc", kText, read_dbc},
    {"role_map", "input.toml", kParameters, read_role_map},
    {"drive_log", "input.txt", kText, read_drive_recording},
    {"cell_log", "input.txt", kText, read_cell_recording},
    {"track", "input.csv", kText, read_track},
    {"course", "input.csv", kText, read_course},
    {"gpx", "input.gpx", kText, read_gpx_course},
    {"course_import", "input.csv", kFitted, import_small_course, kFitSeconds},
    {"drive", "input.csv", kText, read_drive},
    {"run", "input.json", kText, read_run},
    {"vehicle", "input.toml", kParameters, read_vehicle},
    {"cell", "input.toml", kParameters, read_cell},
    {"settings", "input.txt", kParameters, read_settings},
    {"plan", "input.toml", kParameters, read_plan},
}};

}  // namespace

std::span<const FuzzTarget> targets() { return kTargets; }

const FuzzTarget* find_target(std::string_view name) {
  const auto at = std::find_if(kTargets.begin(), kTargets.end(), [&](const FuzzTarget& t) { return t.name == name; });
  return at == kTargets.end() ? nullptr : &*at;
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace voltlap::plant
