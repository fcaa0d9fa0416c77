// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100_watch.hpp"

namespace voltlap::master {
namespace {

constexpr Current kMargin = Current::from_raw(30'000);
constexpr std::int64_t kMarginPercent = 30;
constexpr Duration kAstrayTime = Duration::from_ms(1'000);
constexpr Duration kFrozenTime = Duration::from_ms(100);
constexpr Speed kWheelsMoved = Speed::from_raw(1'000);

Current magnitude(Current c) { return c < Current{} ? -c : c; }

bool astray(const Input& input) {
  if (!input.inverter_dc_current.good() || !input.pack_current.good()) return false;
  const Current inverter = input.inverter_dc_current.value, pack = input.pack_current.value;
  const Current larger = max(magnitude(inverter), magnitude(pack));
  const Current allowed = kMargin + Current::saturated(larger.raw() * kMarginPercent / 100);
  return magnitude(inverter - pack) > allowed;
}

bool frozen(const Input& input, Pm100WatchState& state) {
  const Sample<Speed>&left = input.wheel_speed[2], &right = input.wheel_speed[3];
  if (!input.motor_speed.good() || !left.good() || !right.good()) {
    state.started = false;
    return false;
  }
  if (!state.started || input.motor_speed.value != state.speed) {
    state.started = true;
    state.speed = input.motor_speed.value;
    state.left = left.value;
    state.right = right.value;
  }
  const bool faster = left.value > state.left + kWheelsMoved && right.value > state.right + kWheelsMoved;
  const bool slower = left.value < state.left - kWheelsMoved && right.value < state.right - kWheelsMoved;
  return faster || slower;
}

}  // namespace

void watch_pm100(bool ready_to_drive, const Input& input, Pm100WatchState& state) {
  const bool strays = state.astray.held(ready_to_drive && astray(input), input.now, kAstrayTime);
  const bool stands = state.frozen.held(frozen(input, state), input.now, kFrozenTime);
  state.implausible = stands || strays;
}

void watch_dropping(bool ready_to_drive, const Input& input, InverterDropState& state) {
  const bool known = input.inverter_state.good();
  const InverterState is = input.inverter_state.value;
  const bool able = known && (is == InverterState::kDisabled || is == InverterState::kEnabled);
  if (state.enabled && !able) state.dropped = true;
  if (able) state.dropped = false;
  state.enabled = ready_to_drive && (state.enabled || (known && is == InverterState::kEnabled));
}

}  // namespace voltlap::master
