// SPDX-License-Identifier: Apache-2.0
// What moves the car, between its readings: straight. Frames of one message a few milliseconds after those of
// another are no error of the power.
#pragma once
#include "explain/balances/recording.hpp"
#include "explain/balances/world.hpp"

namespace voltlap::explain {

/// The recording with speed, torque and pedals at the times of the current's rows. Speed, motor speed and torque
/// are reckoned from wheels and motor current where they are not recorded.
[[nodiscard]] plant::Recording interpolated(const plant::World& model, plant::Recording log);

}  // namespace voltlap::explain
