// SPDX-License-Identifier: Apache-2.0
#include "logs/role_map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array kRoles{"time",
                            "current",
                            "voltage",
                            "pack_voltage",
                            "bus_voltage",
                            "cell_voltage_<n>",
                            "temperature_<n>",
                            "ambient",
                            "charge_ah",
                            "soc",
                            "speed",
                            "wheel_speed_<n>",
                            "accelerator",
                            "brake",
                            "motor_speed",
                            "motor_torque"};

struct Unit {
  std::string_view name;
  double scale, offset;
};
constexpr std::array kUnits{Unit{"1", 1, 0},         Unit{"s", 1, 0},       Unit{"ms", 1e-3, 0},
                            Unit{"min", 60, 0},      Unit{"h", 3600, 0},    Unit{"A", 1, 0},
                            Unit{"mA", 1e-3, 0},     Unit{"V", 1, 0},       Unit{"mV", 1e-3, 0},
                            Unit{"degC", 1, 0},      Unit{"K", 1, -273.15}, Unit{"degF", 5.0 / 9.0, -160.0 / 9.0},
                            Unit{"Ah", 1, 0},        Unit{"mAh", 1e-3, 0},  Unit{"As", 1.0 / 3600, 0},
                            Unit{"%", 0.01, 0},      Unit{"m/s", 1, 0},     Unit{"km/h", 1 / 3.6, 0},
                            Unit{"mph", 0.44704, 0}, Unit{"rpm", 1, 0},     Unit{"Nm", 1, 0}};

bool is_role(std::string_view name) {
  for (const std::string_view role : kRoles) {
    const std::size_t stem = role.find("<n>");
    if (stem == std::string_view::npos) {
      if (name == role) return true;
      continue;
    }
    const std::string_view number = name.starts_with(role.substr(0, stem)) ? name.substr(stem) : std::string_view{};
    if (!number.empty() && number[0] != '0' &&
        std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); })) {
      return true;
    }
  }
  return false;
}

Unit unit_of(const std::string& place, const std::string& name) {
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& unit) { return unit.name == name; });
  if (found != kUnits.end()) return *found;
  std::vector<std::string_view> known;
  for (const Unit& unit : kUnits) known.push_back(unit.name);
  throw InputError(place, fmt::format("unit \"{}\"", name), fmt::format("one of {}", fmt::join(known, ", ")),
                   "Use one of these with scale and offset");
}

DischargeSign sign_of(const std::string& place, const std::string& text) {
  if (text == "+") return DischargeSign::kPositive;
  if (text == "-") return DischargeSign::kNegative;
  if (text == "auto") return DischargeSign::kAuto;
  throw InputError(place, fmt::format("discharge = \"{}\"", text), "\"+\", \"-\" or \"auto\"", "Correct the sign");
}

RoleColumn column_of(const std::string& place, const toml::node& node) {
  const toml::table* entry = node.as_table();
  if (entry == nullptr) {
    throw InputError(place, "a value that is no table", "{column = \"...\", unit = \"...\"}", "Name the column");
  }
  for (const auto& [key, value] : *entry) {
    constexpr std::array kKeys{"column", "unit", "scale", "offset", "discharge"};
    if (std::find(kKeys.begin(), kKeys.end(), key.str()) != kKeys.end()) continue;
    const bool frame = key.str() == "frame" || key.str() == "signal" || key.str() == "dbc";
    throw InputError(
        place, fmt::format("key \"{}\"", key.str()), "column, unit, scale, offset, discharge",
        frame ? "A role of a table is a column; export the CAN log to a table first" : "Remove or correct the key");
  }
  RoleColumn out;
  const auto name = (*entry)["column"].value<std::string>();
  if (!name) throw InputError(place, "no column", "column = \"name in the table\"", "Add it");
  out.column = *name;
  const Unit unit = unit_of(place, (*entry)["unit"].value_or(std::string("1")));
  out.scale = (*entry)["scale"].value_or(1.0) * unit.scale;
  out.offset = (*entry)["offset"].value_or(0.0) * unit.scale + unit.offset;
  out.discharge = sign_of(place, (*entry)["discharge"].value_or(std::string("auto")));
  return out;
}

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
  return map.find("time") && map.find("current") && (map.find("voltage") || map.find("pack_voltage"));
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

const RoleColumn* RoleMap::find(const std::string& role) const {
  const auto found = roles.find(role);
  return found == roles.end() ? nullptr : &found->second;
}

RoleMap load_role_map(const std::string& path) {
  toml::table file;
  try {
    file = toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}", path, error.source().begin.line), std::string(error.description()),
                     "TOML", "Mend the line");
  }
  const toml::table* roles = file["roles"].as_table();
  if (roles == nullptr) {
    throw InputError(path, "no [roles]", "[roles] with time, current and voltage",
                     "Give a role map; plant_sim/data/maps has examples");
  }
  RoleMap map;
  map.source = path;
  if (const toml::array* match = file["match"].as_array()) {
    for (const toml::node& header : *match) map.match.push_back(header.value_or(std::string()));
  }
  for (const auto& [key, node] : *roles) {
    const std::string role(key.str());
    const std::string place = fmt::format("{}: roles.{}", path, role);
    if (!is_role(role)) {
      throw InputError(place, "an unknown role", fmt::format("one of {}", fmt::join(kRoles, ", ")),
                       "Correct its name");
    }
    map.roles[role] = column_of(place, node);
  }
  return map;
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
