// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/speed_watch.hpp"

namespace voltlap::master {
namespace {

constexpr Duration kFrozenTime = Duration::from_ms(100);
constexpr Speed kWheelsMoved = Speed::from_raw(1'000);
constexpr Speed kStanding = Speed::from_raw(100);  // chosen: more than a wheel's sensor reads at rest

bool frozen(const Sample<MotorSpeed>& motor, const Sample<Speed>& left, const Sample<Speed>& right,
            SpeedWatch& state) {
  if (!motor.good() || !left.good() || !right.good()) {
    state.started = false;
    return false;
  }
  const bool stand = magnitude(left.value) <= kStanding && magnitude(right.value) <= kStanding;
  if (!state.started || motor.value != state.speed || (stand && motor.value == MotorSpeed{})) {
    state.started = true;
    state.speed = motor.value;
    state.left = left.value;
    state.right = right.value;
  }
  const bool faster = left.value > state.left + kWheelsMoved && right.value > state.right + kWheelsMoved;
  const bool slower = left.value < state.left - kWheelsMoved && right.value < state.right - kWheelsMoved;
  return faster || slower;
}

}  // namespace

bool speed_stands(const Sample<MotorSpeed>& motor, const Sample<Speed>& left, const Sample<Speed>& right, Instant now,
                  SpeedWatch& state) {
  return state.frozen.held(frozen(motor, left, right, state), now, kFrozenTime);
}

}  // namespace voltlap::master
