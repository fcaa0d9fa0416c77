// SPDX-License-Identifier: Apache-2.0
// Testers that write the date in whole seconds beside a finer clock of the step: Neware's "Date" and "Relative Time".
#pragma once
#include "io/logs/role_map.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {

/// Where more than a row in fifty repeats the time of the row before and a clock of the step does not, the time becomes
/// that of the step's begin, by the dates in it, and what the finer clock says; said in the table's repairs. A step
/// that begins within what a date is worth of the end of the one before begins there.
void refine_by_step_clock(const RoleMap& map, MeasuredTable& table);

}  // namespace voltlap::plant
