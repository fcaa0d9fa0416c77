// SPDX-License-Identifier: Apache-2.0
// Frames of the current that a logger lost.
#pragma once
#include "explain/balances/recording.hpp"

namespace voltlap::explain {

/// Leaves out (NaN) the voltages that were read while a row of the current is missing, where a load was going on or
/// off: what flowed when they were read no row tells, and one reading that is off by a whole step outweighs a thousand
/// that are right. Not at rest, where a missing row says what its neighbours say; nor of a log whose rows come as they
/// like, which has no usual interval.
void leave_out_lost_rows(plant::Recording& log, const Eigen::VectorXd& current_a);

/// The usual interval between rows.
[[nodiscard]] double row_interval_s(const Eigen::VectorXd& time_s);

}  // namespace voltlap::explain
