// SPDX-License-Identifier: Apache-2.0
// What the columns of a drive's table say beside time, current and voltage.
#pragma once
#include "io/logs/recorded_signals.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

/// Adds to a map that is enough what columns that it does not use say: cells, thermistors, SOC, speeds, pedals. Units
/// that nobody told are settled (untold_units.hpp), a voltage beyond a cell's is the pack's, and columns that are left
/// are noted.
void add_other_roles(const RecordedSignals& table, RoleMap& map);

}  // namespace voltlap::plant
