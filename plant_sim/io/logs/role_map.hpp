// SPDX-License-Identifier: Apache-2.0
// Which column of a table or which signal of a CAN recording plays which role, in which unit and with which sign
// (files: plant_sim/data/maps/*.toml; all keys in its README).
//
//   match = ["t,I,U"]           # optional: header lines that this map is chosen for without --map
//   match_columns = ["t", "I"]  # optional: columns that a table must have for the same
//   match_frames = [0x6B0]      # optional: identifiers that a CAN recording must have for the same
//   temperatures_of_core = true # optional: of the cells within, as a simulation has them, not of their surface
//   [roles]
//   current = {column = "I", unit = "A", scale = 1, offset = 0, discharge = "+"}   # "+", "-" or "auto"
//   voltage = {column = "U", unit = "mV"}
//   pack_voltage = {frame = 0x6B0, signal = "PackVoltage", dbc = "orion.dbc", checksum = "orion"}
//   "cell_voltage_<n>" = {frame = 0x036, signal = "CellVoltage", index = "CellId", first = 0, dbc = "orion.dbc"}
//   temperature_1 = {file = "thermocouples.csv", column = "tc", time = "t_s", shift_s = 0}
//
// value in SI = (raw * scale + offset) * size of the unit. Roles: see role_names(); <n> counts from 1. Paths are
// relative to the map; $VOLTLAP_DATA is the folder of measured data.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "io/logs/role_source.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {

struct RoleMap {
  std::string source;                       ///< file or "column names", for reports
  std::vector<std::string> match;           ///< header lines that it fits
  std::vector<std::string> match_columns{};  ///< columns of a table that it fits
  std::vector<std::uint32_t> match_frames;  ///< identifiers of a CAN recording that it fits, without flags
  bool temperatures_of_core = false;        ///< of the cells within, not where a thermistor sits
  std::map<std::string, RoleSource> roles;  ///< by role name; <n> may stand for all numbers at once
  std::vector<std::string> notes{};         ///< how columns were recognised where no map named them
  [[nodiscard]] const RoleSource* find(const std::string& role) const;
};

/// Reads a role map. Throws InputError that names the file and the role for an unknown role, unit or key.
[[nodiscard]] RoleMap load_role_map(const std::string& path);

/// A path that stands in a map: relative to it, $VOLTLAP_DATA expanded. Throws InputError when that is not set.
[[nodiscard]] std::string path_in_map(const RoleMap& map, const std::string& text);

/// The map for a table without a map of its own: the plain column names (time_s, current_a, voltage_v, ...), else
/// the shipped map whose `match` has its header, else the names that makers of cyclers and loggers use. Throws
/// InputError with a draft map when none fits, and when two columns may play the same role.
[[nodiscard]] RoleMap role_map_for(const MeasuredTable& table, const DataFolder& data);

}  // namespace voltlap::plant
