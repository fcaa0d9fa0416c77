// SPDX-License-Identifier: Apache-2.0
// MST-069: one current for the car becomes four, for a motor at each wheel.
//   I = s I_all / 2 in front, (1 - s) I_all / 2 behind, each cut towards zero and at its own limit
// s is a share of its own in driving and in braking. Left and right are alike: what one wheel could not give is given
// by none of the others, for it would turn the car.
#pragma once
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

[[nodiscard]] WheelCurrents split_torque(const Config& config, Current all);

}  // namespace voltlap::master
