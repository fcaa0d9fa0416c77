// SPDX-License-Identifier: Apache-2.0
// What a counter of the charge says of the current between two rows: ten rows a second miss how long a pull was
// that began or ended between two of them, and the charge of a whole drive with it.
#pragma once
#include "explain/balances/recording.hpp"

namespace voltlap::plant {

/// Mean current of the pack from the row before until each row [A], discharge positive, by the counter `charge_ah`
/// of the log; NaN where it says nothing (a restart, a missing value). Empty where there is no counter of every
/// row, or one that contradicts the current, or one of steps so coarse that the rows tell more.
[[nodiscard]] Eigen::VectorXd counted_current(const Recording& log);

}  // namespace voltlap::plant
