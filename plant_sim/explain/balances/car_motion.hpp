// SPDX-License-Identifier: Apache-2.0
// How a car with recorded motor, pedals and speed moves: forces on it, what its tyres slip, from the plant's own motor,
// tyre, brakes and road.
//
//   (m + J / r^2) a  =  T i eta / r - drag - rolling - m g slope - brakes - drag of corners (of a logged a_y)
//   motor speed      =  v (1 + slip(F, N)) i / r,   F = T i eta / r - J_driven a / r^2, N beside what a corner takes
#pragma once
#include "explain/balances/balances.hpp"

namespace voltlap::plant {

inline constexpr double kMoving = 2.0;  // m/s; below it neither slip nor force is judged
inline constexpr double kTouch = 0.01;  // of the brake pedal; below it the pads do not touch, what is read is noise

/// By row [m/s2].
[[nodiscard]] Eigen::VectorXd acceleration_of(const World& world, const Comparison& comparison);

/// Speed [m/s] that the car does not gain since the row before, negative: driven wheels that begin to slip take it, as
/// their speed is recorded. Empty without it.
[[nodiscard]] Eigen::VectorXd spun_up(const World& world, const Recording& log);

/// By row [rpm]; NaN below kMoving.
[[nodiscard]] Eigen::VectorXd motor_speed_of(const World& world, const Comparison& comparison);

}  // namespace voltlap::plant
