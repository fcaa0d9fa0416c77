// SPDX-License-Identifier: Apache-2.0
// Shapes that a residual could have and that no cause owns: plain functions of current, charge, time, heat, speed and
// torque, and the same behind lags. When one of them explains a log better than the catalogue does, the cause is
// unknown.
#pragma once
#include <vector>

#include "discrepancy/design.hpp"

namespace voltlap::plant {

[[nodiscard]] std::vector<Column> anonymous_columns(const Design& design);

/// Is a shape of this kind, of the cells' voltage, behind the current or over the charge? Others follow it at once.
[[nodiscard]] bool is_late_kind(std::size_t kin);

/// Size [V, K, Nm, m/s, rpm] that counts as usual for a shape in this channel.
[[nodiscard]] double usual_size(const BalanceChannel& channel, double cells_in_series);

}  // namespace voltlap::plant
