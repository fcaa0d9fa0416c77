// SPDX-License-Identifier: Apache-2.0
#include "io/logs/role_map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

/// A table that keeps to the plain names needs no map: role_unit, such as time_s, current_ma, temperature_2_c.
RoleMap plain_map(const MeasuredTable& table) {
  struct Suffix {
    std::string_view text, unit;
  };
  constexpr std::array kSuffixes{
      Suffix{"_s", "s"},   Suffix{"_ms", "ms"},  Suffix{"_a", "A"},     Suffix{"_ma", "mA"},   Suffix{"_v", "V"},
      Suffix{"_mv", "mV"}, Suffix{"_c", "degC"}, Suffix{"_mps", "m/s"}, Suffix{"_rpm", "rpm"}, Suffix{"_nm", "Nm"}};
  RoleMap map;
  map.source = "column names";
  const auto add = [&](const std::string& role, const std::string& column, std::string_view unit_name) {
    if (!is_role(role) || map.roles.contains(role)) return;
    const Unit unit = unit_of(table.path, std::string(unit_name));
    map.roles[role] = {column, unit.scale, unit.offset, DischargeSign::kAuto};
  };
  for (const std::string& column : table.columns) {
    if (is_role(column)) add(column, column, "1");
    for (const Suffix& suffix : kSuffixes) {
      if (!column.ends_with(suffix.text)) continue;
      std::string role = column.substr(0, column.size() - suffix.text.size());
      if (role == "pack_current") role = "current";
      if (role == "temperature") role = "temperature_1";
      add(role, column, suffix.unit);
    }
  }
  return map;
}

bool is_enough(const RoleMap& map) {
  return map.find("time") && map.find("current") &&
         (map.find("voltage") || map.find("pack_voltage") || map.find("cell_voltage_1"));
}

std::string draft(const MeasuredTable& table) {
  const auto like = [&](std::initializer_list<std::string_view> words) -> std::string {
    for (const std::string& column : table.columns) {
      std::string lower = column;
      std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
      for (const auto word : words) {
        if (lower.starts_with(word)) return column;
      }
    }
    return "?";
  };
  return fmt::format(
      "[roles]\ntime = {{column = \"{}\", unit = \"s\"}}\n"
      "current = {{column = \"{}\", unit = \"A\", discharge = \"auto\"}}\n"
      "voltage = {{column = \"{}\", unit = \"V\"}}\n",
      like({"t", "zeit", "sec"}), like({"i", "cur", "a", "strom"}), like({"v", "u", "spann"}));
}

}  // namespace

const RoleSource* RoleMap::find(const std::string& role) const {
  const auto found = roles.find(role);
  return found == roles.end() ? nullptr : &found->second;
}

std::string path_in_map(const RoleMap& map, const std::string& text) {
  constexpr std::string_view kVariable = "$VOLTLAP_DATA";
  if (!text.starts_with(kVariable)) {
    // An absolute path replaces what stands before it.
    return (std::filesystem::path(map.source).parent_path() / text).lexically_normal().string();
  }
  const char* folder = std::getenv("VOLTLAP_DATA");
  if (folder == nullptr || *folder == '\0') {
    throw InputError(map.source, fmt::format("\"{}\" while VOLTLAP_DATA is not set", text),
                     "the folder of measured data in VOLTLAP_DATA",
                     "Set it, or copy the map and give the path there");
  }
  return folder + text.substr(kVariable.size());
}

RoleMap role_map_for(const MeasuredTable& table, const DataFolder& data) {
  const RoleMap plain = plain_map(table);
  if (is_enough(plain)) return plain;
  const std::string header = fmt::format("{}", fmt::join(table.columns, ","));
  for (const std::string& name : data.names("maps")) {
    RoleMap map = load_role_map(data.find("maps", name, "maps"));
    if (std::find(map.match.begin(), map.match.end(), header) != map.match.end()) return map;
  }
  throw InputError(table.path, fmt::format("columns {}", fmt::join(table.columns, ", ")),
                   "time_s, current_a and voltage_v, or a role map (--map)",
                   "This draft is a start for one; save it, correct it and give it with --map:\n" + draft(table));
}

}  // namespace voltlap::plant
