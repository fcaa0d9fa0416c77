// SPDX-License-Identifier: Apache-2.0
// What a sound model of a car usually misses: forces, losses and slip, the road, and the pedal as a second measure
// of the torque.
#pragma once
#include "explain/shapes/channel_shapes.hpp"

namespace voltlap::plant {

/// Shapes of one of the channels of car_balances.hpp.
void car_shapes(const Shown& shown, const BalanceChannel& channel, Shapes& shapes);

}  // namespace voltlap::plant
