// SPDX-License-Identifier: Apache-2.0
// What the channels show of a cause that sits in some members of a group: their mean moves, and with it what the mean
// tells. The mean cell voltage tells the SOC at a first rest and the heat, the mean thermistor the resistances.
#pragma once
#include <vector>

#include "discrepancy/balances.hpp"

namespace voltlap::plant {

/// By channel; empty: nothing there. `on_member` is what one member's reading gains, `members` of the group have it, or
/// their sensors alone (`of_sensor`). `base` is the prediction of `model` for this log.
[[nodiscard]] std::vector<Eigen::VectorXd> member_effect(const World& model, const Comparison& on,
                                                         const Prediction& base, const Group& group,
                                                         const Eigen::VectorXd& on_member, std::size_t members,
                                                         bool of_sensor);

}  // namespace voltlap::plant
