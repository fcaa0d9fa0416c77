// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/amk_watch.hpp"

namespace voltlap::master {
namespace {

constexpr Duration kDcOnTime = Duration::from_ms(500);  // assumed: what an inverter takes to switch its DC link on

/// The first wheel of the axle of a wheel.
constexpr std::size_t left_of(std::size_t wheel) { return wheel < 2 ? 0 : 2; }

void watch_each(const Config& config, const Input& input, AmkWatchState& state) {
  state.disobeys = false;
  for (std::size_t k = 0; k < kWheels; ++k) {
    watch_current(input.motors.current[k], config.inverter_excess_max, input.now, state.each[k]);
    const std::size_t left = left_of(k);
    const bool stands = speed_stands(input.motors.speed[k], input.wheel_speed[left], input.wheel_speed[left + 1],
                                     input.now, state.speed[k]);
    state.disobeys = state.disobeys || stands || state.each[k].disobeys;
  }
}

void watch_sequence(DriveState mode, const Input& input, AmkWatchState& state) {
  const bool known = input.inverter_state.good();
  const bool on = known && input.inverter_state.value == InverterState::kEnabled;
  const bool dc_on = on || (known && input.inverter_state.value == InverterState::kDisabled);
  const bool driving = mode == DriveState::kReadyToDrive;
  // One that is no longer asked, for its frames are late, switches off as it should: it is missed when it is not heard.
  if (state.drove && (!dc_on || (state.asked && state.was_on && !on))) state.dropped = true;
  if (!driving && dc_on) state.dropped = false;
  state.was_on = state.asked && on;
  state.drove = driving && (state.drove || on);
  state.waits = !dc_on;
  const bool expected = mode == DriveState::kTsActive || mode == DriveState::kReadyToDrive;
  state.late = state.off.held(expected && state.waits, input.now, kDcOnTime);
}

}  // namespace

void watch_amk(const Config& config, DriveState mode, const Input& input, AmkWatchState& state) {
  watch_each(config, input, state);
  watch_sequence(mode, input, state);
}

void note_asked(const Output& output, Duration elapsed, AmkWatchState& state) {
  const Current* sent = output.wheel.of;
  for (InverterWatchState& one : state.each) note_asked(*sent++, elapsed, one);
  state.asked = output.enable;
}

}  // namespace voltlap::master
