// SPDX-License-Identifier: Apache-2.0
// The temperatures of a cell's test, whatever their columns are called.
#pragma once
#include "io/logs/role_map.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {

/// Where a map that was made from names has no temperature of the cell, or none of the air: the column that is one by
/// its unit or by a word of its name, a chamber's the air's. What was taken, and what was left, goes to the notes:
/// none is left out in silence.
void add_temperatures(const MeasuredTable& table, RoleMap& map);

}  // namespace voltlap::plant
