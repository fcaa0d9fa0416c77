// SPDX-License-Identifier: Apache-2.0
// Roles of a table's columns from their names and units, where no map names them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/logs/role_map.hpp"
#include "io/table/unit_name.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {

/// Unit that the file itself gives for a column: its row of units, or the name's "[mA]", "(mA)", "/mA", "_mA".
[[nodiscard]] std::optional<NamedUnit> file_unit(const MeasuredTable& table, std::size_t column);

/// A role's source with the unit that the file gives where the map names none (then said in `notes`). Throws
/// InputError where the map's unit contradicts the file's.
[[nodiscard]] RoleSource with_file_unit(const RoleSource& source, const std::string& role, const MeasuredTable& table,
                                        const std::string& map, std::vector<std::string>& notes);

/// Plain names: role_unit, such as time_s, current_ma, temperature_2_c. Throws InputError where two columns that
/// differ have names of the same role, when time, current and a voltage are among the roles.
[[nodiscard]] RoleMap plain_map(const MeasuredTable& table);

/// The names that Arbin, Basytec, BioLogic, Digatron, Maccor, Neware, AiM and MoTeC write, and others alike. Throws
/// InputError where two columns may play the same role.
[[nodiscard]] RoleMap recognised_map(const MeasuredTable& table);

/// A column that by its name is a clock which begins again with each step of a test, and its unit [s].
struct StepClock {
  std::size_t column = 0;
  double scale = 1.0;
};
[[nodiscard]] std::optional<StepClock> step_clock(const MeasuredTable& table);

/// The pack's voltage of a table of which time, current and cells have plain names, and it has not.
void add_pack_voltage(const MeasuredTable& table, RoleMap& map);

/// Time, current and a voltage.
[[nodiscard]] bool is_enough(const RoleMap& map);

/// Some cyclers write amounts and a state beside them (Maccor: C, D, R). Where the current is never negative and the
/// words of a column tell charge from discharge, it gets its sign, discharge positive; what was done in words.
[[nodiscard]] std::optional<std::string> sign_by_state(const MeasuredTable& table, std::vector<double>& current);

}  // namespace voltlap::plant
