// SPDX-License-Identifier: Apache-2.0
#include "io/logs/role_map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "base/can_frame.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

DischargeSign sign_of(const std::string& place, const std::string& text) {
  if (text == "+") return DischargeSign::kPositive;
  if (text == "-") return DischargeSign::kNegative;
  if (text == "auto") return DischargeSign::kAuto;
  throw InputError(place, fmt::format("discharge = \"{}\"", text), "\"+\", \"-\" or \"auto\"", "Correct the sign");
}

FrameChecksum checksum_of(const std::string& place, const std::string& text) {
  if (text.empty()) return FrameChecksum::kNone;
  if (text == "orion") return FrameChecksum::kOrion;
  if (text == "sum") return FrameChecksum::kSum;
  throw InputError(place, fmt::format("checksum = \"{}\"", text),
                   "\"orion\" (identifier + 8 + sum of bytes 0 to 6) or \"sum\" (of bytes 0 to 6)",
                   "Correct or remove it");
}

void check_keys(const std::string& place, const toml::table& entry, bool frame) {
  constexpr std::array kEither{"unit", "scale",   "offset", "discharge", "index",  "first",
                               "file", "shift_s", "min",    "max",       "invalid"};
  constexpr std::array kColumn{"column", "time"};
  constexpr std::array kFrame{"frame", "extended", "signal", "dbc", "checksum", "counter", "bus", "period_s"};
  for (const auto& [key, value] : entry) {
    const auto in = [&](const auto& keys) { return std::find(keys.begin(), keys.end(), key.str()) != keys.end(); };
    if (in(kEither) || (frame ? in(kFrame) : in(kColumn))) continue;
    std::vector<std::string_view> known;
    if (frame) known.insert(known.end(), kFrame.begin(), kFrame.end());
    if (!frame) known.insert(known.end(), kColumn.begin(), kColumn.end());
    known.insert(known.end(), kEither.begin(), kEither.end());
    throw InputError(place, fmt::format("key \"{}\"", key.str()), fmt::format("{}", fmt::join(known, ", ")),
                     "Remove or correct the key");
  }
}

std::string text_of(const std::string& place, const toml::table& entry, const char* key, const char* needed) {
  const auto text = entry[key].value<std::string>();
  if (!text && needed != nullptr) throw InputError(place, fmt::format("no {}", key), needed, "Add it");
  return text.value_or(std::string());
}

void take_frame(const std::string& place, const toml::table& entry, RoleSource& out) {
  constexpr std::int64_t kLastStandard = 0x7FF, kLastExtended = 0x1FFFFFFF;
  const auto id = entry["frame"].value<std::int64_t>();
  if (!id || *id < 0 || *id > kLastExtended) {
    throw InputError(place, "frame = " + (id ? fmt::format("{}", *id) : "no whole number"),
                     "an identifier of 11 or 29 bits such as 0x6B0", "Correct it");
  }
  const bool extended = *id > kLastStandard || entry["extended"].value_or(false);
  out.frame = static_cast<std::uint32_t>(*id) | (extended ? Frame::kExtendedFlag : 0U);
  out.signal = text_of(place, entry, "signal", "signal = \"name in the DBC\"");
  out.dbc = text_of(place, entry, "dbc", "dbc = \"file.dbc\"");
  out.checksum = checksum_of(place, text_of(place, entry, "checksum", nullptr));
  out.counter = text_of(place, entry, "counter", nullptr);
  out.bus = text_of(place, entry, "bus", nullptr);
  out.period_s = entry["period_s"].value<double>();
}

RoleSource source_of(const std::string& place, const toml::node& node) {
  const toml::table* entry = node.as_table();
  if (entry == nullptr) {
    throw InputError(place, "a value that is no table",
                     "{column = \"...\", unit = \"...\"} or {frame = 0x..., signal = \"...\", dbc = \"...\"}",
                     "Name the column or the signal");
  }
  const bool frame = entry->contains("frame");
  check_keys(place, *entry, frame);
  RoleSource out;
  if (frame) take_frame(place, *entry, out);
  if (!frame)
    out.column = text_of(place, *entry, "column", "column = \"name in the table\", or frame, signal and dbc");
  const Unit unit = unit_of(place, (*entry)["unit"].value_or(std::string("1")));
  out.scale = (*entry)["scale"].value_or(1.0) * unit.scale;
  out.offset = (*entry)["offset"].value_or(0.0) * unit.scale + unit.offset;
  out.discharge = sign_of(place, (*entry)["discharge"].value_or(std::string("auto")));
  out.index = text_of(place, *entry, "index", nullptr);
  if (const auto first = (*entry)["first"].value<std::int64_t>()) out.first = static_cast<long>(*first);
  out.file = text_of(place, *entry, "file", nullptr);
  out.time = text_of(place, *entry, "time", nullptr);
  out.shift_s = (*entry)["shift_s"].value_or(0.0);
  out.min = (*entry)["min"].value<double>();
  out.max = (*entry)["max"].value<double>();
  if (const toml::array* codes = (*entry)["invalid"].as_array()) {
    for (const toml::node& code : *codes) out.invalid.push_back(code.value_or(0.0));
  }
  if (!out.index.empty() && place.find("<n>") == std::string::npos) {
    throw InputError(place, "index", "it only for a role with <n>, such as \"cell_voltage_<n>\"",
                     "Correct the role");
  }
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

RoleMap load_role_map(const std::string& path) {
  toml::table file;
  try {
    note_input(path);
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
  if (const toml::array* ids = file["match_frames"].as_array()) {
    for (const toml::node& id : *ids) {
      map.match_frames.push_back(static_cast<std::uint32_t>(id.value_or(std::int64_t{0})));
    }
  }
  for (const auto& [key, node] : *roles) {
    const std::string role(key.str());
    const std::string place = fmt::format("{}: roles.{}", path, role);
    if (!is_role(role)) {
      throw InputError(place, "an unknown role", fmt::format("one of {}", fmt::join(role_names(), ", ")),
                       "Correct its name");
    }
    map.roles[role] = source_of(place, node);
  }
  return map;
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
