// SPDX-License-Identifier: Apache-2.0
// The balances of a car with recorded motor, pedals and speed, from the plant's own motor, inverter, tyre and
// brakes.
//
//   power        V I  =  P_dc(torque, motor speed) + auxiliary
//   speed        m dv/dt  =  torque i eta / r - drag - rolling - m g slope - brakes - drag of corners (of a logged
//                lateral acceleration)
//   motor_speed  =  v (1 + slip(force)) i / r
//   motor_torque =  -(share of braking that the motor takes), while the accelerator is released
// Power is compared as the torque that would make the difference, because noise and wander of the recorded torque
// come into it by the motor's speed. Speed is compared as what was gained over the last 2 s, which is what a sum
// that forgets keeps of it. Measured and predicted gain go through the same sum; noise of the speed stays white in
// it, and the slope of the road stays slow. What was gained while a pedal moved between rows that are far apart is in
// neither.
#pragma once
#include <string>
#include <vector>

#include "explain/balances/balances.hpp"

namespace voltlap::plant {

/// Of pack or bus; null where neither is recorded.
[[nodiscard]] const Eigen::VectorXd* pack_voltage(const Recording& log);

/// The balances that the log can feed; none for a cell or a pack.
[[nodiscard]] std::vector<BalanceChannel> car_channels(const World& model, const Recording& log);

/// False where tyres hold the car back in corners, and the log does not say how it corners.
[[nodiscard]] bool knows_cornering(const World& model, const Recording& log);

/// What of a power [W] by row is left in the channel `power` [Nm].
[[nodiscard]] Eigen::VectorXd power_as_torque(const Recording& log, const Eigen::VectorXd& power);

/// What of an acceleration [m/s2] by row, and of a gain since the row before [m/s], is left in the channel `speed`
/// [m/s].
[[nodiscard]] Eigen::VectorXd gain_of_speed(const Recording& log, const Eigen::VectorXd& acceleration,
                                            const Eigen::VectorXd& beside = {});

/// By row: is what was gained since the row before known? Not where a pedal moved between rows that are far apart.
[[nodiscard]] std::vector<bool> knows_gain(const Recording& log);

[[nodiscard]] Eigen::VectorXd car_prediction(const std::string& channel, const World& world,
                                             const Comparison& comparison, const BatteryResponse& battery);

}  // namespace voltlap::plant
