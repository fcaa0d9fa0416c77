// SPDX-License-Identifier: Apache-2.0
// The balances of a car with recorded motor, pedals and speed, from the plant's own motor, inverter, tyre and brakes.
//
//   power        V I  =  P_dc(torque, motor speed) + auxiliary
//   speed        m dv/dt  =  torque i eta / r - drag - rolling - m g slope - brakes
//   motor_speed  =  v (1 + slip(force)) i / r
#pragma once
#include <string>
#include <vector>

#include "discrepancy/balances.hpp"

namespace voltlap::plant {

/// The balances that the log can feed; none for a cell or a pack.
[[nodiscard]] std::vector<BalanceChannel> car_channels(const World& model, const Recording& log);

[[nodiscard]] Eigen::VectorXd car_prediction(const std::string& channel, const World& world,
                                             const Comparison& comparison, const BatteryResponse& battery);

}  // namespace voltlap::plant
