// SPDX-License-Identifier: Apache-2.0
// Which column of a recording plays which role, in which unit and with which sign (files:
// plant_sim/data/maps/*.toml).
//
//   [roles]
//   current = {column = "I", unit = "A", scale = 1, offset = 0, discharge = "+"}   # "+", "-" or "auto"
//   voltage = {column = "U", unit = "mV"}
//   match = ["t,I,U"]           # optional, above [roles]: header lines that this map is chosen for without --map
//
// value in SI = (raw * scale + offset) * size of the unit. Roles: see kRoles; <n> counts from 1.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "logs/table_file.hpp"

namespace voltlap::plant {

enum class DischargeSign { kPositive, kNegative, kAuto };

struct RoleColumn {
  std::string column;
  double scale = 1.0, offset = 0.0;  ///< raw to SI: raw * scale + offset
  DischargeSign discharge = DischargeSign::kAuto;
};

struct RoleMap {
  std::string source;                       ///< file or "column names", for reports
  std::vector<std::string> match;           ///< header lines that it fits
  std::map<std::string, RoleColumn> roles;  ///< by role name
  [[nodiscard]] const RoleColumn* find(const std::string& role) const;
};

/// Reads a role map. Throws InputError that names the file and the role for an unknown role, unit or key, and for a
/// role that is taken from a CAN frame (tables have none).
[[nodiscard]] RoleMap load_role_map(const std::string& path);

/// The map for a table without a map of its own: the plain column names (time_s, current_a, voltage_v, ...), else
/// the shipped map whose `match` has its header. Throws InputError with a draft map when neither fits.
[[nodiscard]] RoleMap role_map_for(const MeasuredTable& table, const DataFolder& data);

}  // namespace voltlap::plant
