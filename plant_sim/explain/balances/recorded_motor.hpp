// SPDX-License-Identifier: Apache-2.0
// Torque and losses of the motor in a recording, by what inverter or pedal report.
#pragma once
#include "explain/balances/balances.hpp"

namespace voltlap::plant {

inline constexpr double kRpm = 2.0 * 3.14159265358979323846 / 60.0;  // rad/s

/// Motor torque at the shaft that the pedal asks for, along the motor's curve; NaN where the pedal is unknown.
[[nodiscard]] Eigen::VectorXd torque_of_pedal(const World& world, const Recording& log);

/// Motor torque at the shaft that inverter or pedal report.
[[nodiscard]] Eigen::VectorXd reported_torque(const World& world, const Comparison& comparison);

/// What the motor really gives for it.
[[nodiscard]] Eigen::VectorXd true_torque(const World& world, const Comparison& comparison,
                                          const Eigen::VectorXd& reported);

/// Kelvin above ambient of the winding, from the model's losses at that torque.
[[nodiscard]] Eigen::VectorXd winding_above_ambient(const World& world, const Comparison& comparison,
                                                    const Eigen::VectorXd& torque);

/// Loss [W] of the current that weakens the field beyond the base speed, against the base speed that the model has.
[[nodiscard]] double weakening_loss(const World& world, double omega);

}  // namespace voltlap::plant
