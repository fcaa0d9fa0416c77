// SPDX-License-Identifier: Apache-2.0
// Cells in a table whose rows hold what was read some rows before: a battery unit sends them in turn, and a row has of
// each the last that came.
#pragma once
#include "explain/balances/battery_response.hpp"

namespace voltlap::plant {

/// Finds out whether the cells of a table (each stands at the rows' own times) are held, by values that stand while the
/// current moves; then each is taken as read where it changes, and once in each turn where it does not, amid the row
/// before and that one (`read_s`, `age_s`).
void settle_held_cells(Recording& log);

/// What cells of a table are beyond the model's voltage at the row's time [V], for they were read before; and as far as
/// that was under any other load, by the mean of the drive.
[[nodiscard]] Eigen::VectorXd older_cells(const World& world, const Eigen::VectorXd& time_s,
                                          const BatteryResponse& battery);

}  // namespace voltlap::plant
