// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100_watch.hpp"

namespace voltlap::master {
namespace {

constexpr Current kMargin = Current::from_raw(30'000);
constexpr std::int64_t kMarginPercent = 30;
constexpr Duration kAstrayTime = Duration::from_ms(1'000);

bool astray(const Input& input) {
  if (!input.inverter_dc_current.good() || !input.pack_current.good()) return false;
  const Current inverter = input.inverter_dc_current.value, pack = input.pack_current.value;
  const Current larger = max(magnitude(inverter), magnitude(pack));
  const Current allowed = kMargin + Current::saturated(larger.raw() * kMarginPercent / 100);
  return magnitude(inverter - pack) > allowed;
}

}  // namespace

void watch_pm100(bool ready_to_drive, const Input& input, Pm100WatchState& state) {
  const bool strays = state.astray.held(ready_to_drive && astray(input), input.now, kAstrayTime);
  const bool stands =
      speed_stands(input.motor_speed, input.wheel_speed[2], input.wheel_speed[3], input.now, state.speed);
  state.implausible = stands || strays;
}

void watch_dropping(bool ready_to_drive, const Input& input, InverterDropState& state) {
  const bool known = input.inverter_state.good();
  const InverterState is = input.inverter_state.value;
  const bool able = known && (is == InverterState::kDisabled || is == InverterState::kEnabled);
  state.dropped = !able && (state.dropped || state.enabled);
  state.enabled = ready_to_drive && (state.enabled || (known && is == InverterState::kEnabled));
}

}  // namespace voltlap::master
