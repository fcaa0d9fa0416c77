// SPDX-License-Identifier: Apache-2.0
#include "master/request.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kFull = 1'000'000;

// The inverter has missed commands for longer than this: as with all other data, the pedal must be released.
constexpr Duration kInverterWaitMax = Duration::from_ms(50);  // beyond the 50 ms after which it says so

bool inverter_usable(const Input& input) {
  return input.inverter_state.good() && (input.inverter_state.value == InverterState::kDisabled ||
                                         input.inverter_state.value == InverterState::kEnabled);
}

// MST-061: nobody knows which of two senders is the car's.
bool foreign_frames(const Input& input) { return input.foreign_frames || input.bms_hears_foreign; }

// An inverter that misses commands for less than 100 ms, and for nothing else, is no interruption.
void wait_for_inverter(bool others, const Input& input, RequestState& state) {
  if (state.armed) {
    state.waiting = true;
    state.waiting_since = input.now;
  }
  const bool missed = input.inverter_state.good() && input.inverter_state.value == InverterState::kCommandTimeout;
  const bool short_enough = input.now - state.waiting_since < kInverterWaitMax;
  state.waiting = state.waiting && others && short_enough && (missed || inverter_usable(input));
}

// MST-022: regeneration only where configured, in proportion to brake pressure, with the accelerator released.
Current regen_request(const Config& config, const PedalState& pedals) {
  if (!pedals.released || !pedals.brake_pressed) return Current{};
  const std::int64_t over = (pedals.brake_pressure - config.brake_pressed_level).raw();
  const std::int64_t span = (config.regen_full_level - config.brake_pressed_level).raw();
  VOLTLAP_REQUIRE(span > 0);
  return -min(Current::saturated(config.regen_current_max.raw() * over / span), config.regen_current_max);
}

// MST-021: the request may grow, in either direction, only so fast; it shrinks at once.
Current rate_limited(Current target, Current previous, Current step) {
  const Current zero{};
  return max(min(target, max(previous, zero) + step), min(previous, zero) - step);
}

}  // namespace

Ratio beyond_dead_zone(Ratio position, Ratio zone) {
  const std::int64_t span = kFull - zone.raw();
  return max(Ratio::saturated((position - zone).raw() * kFull / span), Ratio{});
}

Ratio request_at(Ratio travel, Ratio at_half) {
  const std::int64_t p = travel.raw(), h = at_half.raw();
  return Ratio::saturated(((4 * h - kFull) * p + (2 * kFull - 4 * h) * p / kFull * p) / kFull);
}

void request_step(const Config& config, const Input& input, const PedalState& pedals, DriveState mode,
                  Duration elapsed, RequestState& state) {
  VOLTLAP_REQUIRE(elapsed >= Duration{});
  // MST-020: after every interruption torque comes back only from a released pedal.
  const bool others = mode == DriveState::kReadyToDrive && !pedals.latched.any() && !foreign_frames(input);
  const bool permitted = others && inverter_usable(input);
  wait_for_inverter(others, input, state);
  state.armed = permitted && (state.waiting || pedals.released);
  if (!state.armed) {
    state.pedal = Ratio{};
    state.current = Current{};
    return;
  }
  state.pedal = request_at(beyond_dead_zone(pedals.position, config.pedal_dead_zone), config.pedal_at_half);
  const Current drive = Current::saturated(std::int64_t{config.phase_current_max.raw()} * state.pedal.raw() / kFull);
  const Current target = drive > Current{} ? drive : regen_request(config, pedals);
  const Current step = Current::saturated(std::int64_t{config.request_rise_ma_per_ms} * elapsed.ms());
  state.current = rate_limited(target, state.current, step);
  VOLTLAP_REQUIRE(-config.regen_current_max <= state.current && state.current <= config.phase_current_max);
}

}  // namespace voltlap::master
