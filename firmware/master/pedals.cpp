// SPDX-License-Identifier: Apache-2.0
#include "master/pedals.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kFull = 1'000'000;

struct Accelerator {
  bool lost = false;      ///< no fresh sample
  bool in_range = false;  ///< both channels good and inside their electrical range; else no agreement and no travel
  bool agree = false;
  Ratio low{}, high{};    ///< the lower and the higher of the two travels
};

bool lost(Quality q) { return q == Quality::kNone || q == Quality::kStale; }

bool in_range(const AppsChannel& channel, const Sample<Potential>& s) {
  return s.good() && channel.range_min <= s.value && s.value <= channel.range_max;
}

Accelerator read_accelerator(const Config& config, const Input& input) {
  Accelerator a;
  a.lost = lost(input.apps1.quality) || lost(input.apps2.quality);
  a.in_range = in_range(config.apps1, input.apps1) && in_range(config.apps2, input.apps2);
  if (!a.in_range) return a;
  const Ratio first = apps_travel(config.apps1, input.apps1.value);
  const Ratio second = apps_travel(config.apps2, input.apps2.value);
  a.low = min(first, second);
  a.high = max(first, second);
  a.agree = a.high - a.low <= config.apps_disagreement_max;
  return a;
}

void read_brake(const Config& config, const Input& input, PedalState& state) {
  state.brake_pressure = Pressure{};
  if (input.brake_front.good()) state.brake_pressure = max(state.brake_pressure, input.brake_front.value);
  if (input.brake_rear.good()) state.brake_pressure = max(state.brake_pressure, input.brake_rear.value);
  state.brake_pressed = state.brake_pressure > config.brake_pressed_level;
}

// Nobody brakes hard with one circuit, and the stop that a burst one leaves is one without motor, too. Of good sensors.
bool brakes_disagree(const Config& config, const Input& input) {
  const Pressure front = input.brake_front.value, rear = input.brake_rear.value;
  return max(front, rear) > config.brake_compare_level && min(front, rear) <= config.brake_pressed_level;
}

}  // namespace

Ratio apps_travel(const AppsChannel& channel, Potential voltage) {
  const std::int64_t span = (channel.full - channel.released).raw();
  if (span <= 0) return Ratio{};
  const std::int64_t travel = (voltage - channel.released).raw() * kFull / span;
  return max(min(Ratio::saturated(travel), Ratio::from_raw(kFull)), Ratio{});
}

void pedals_step(const Config& config, const Input& input, PedalState& state) {
  const Accelerator a = read_accelerator(config, input);
  read_brake(config, input, state);
  const bool brakes_good = input.brake_front.good() && input.brake_rear.good();

  Faults active;
  // MST-001: pedals that are lost for their timeout, 100 ms, are believed again only when released. MST-050 has
  // stopped the torque before.
  active.set(MasterFault::kPedalsLost, a.lost);
  // MST-006: what comes and goes, as a loose plug does, is counted on; it is there for its time in all.
  // MST-002 (T.4.2.10, T.4.2.5) and MST-003 (T.4.2.4, T.4.2.5): a sensor outside its range, two that disagree.
  active.set(MasterFault::kAppsRange, state.apps_range.held(!a.in_range, input.now, config.apps_implausible_time));
  active.set(MasterFault::kAppsImplausible,
             state.apps_disagree.held(a.in_range && !a.agree, input.now, config.apps_implausible_time));
  // MST-004 (T.4.3): a brake sensor that has failed, or two that cannot both be right (MST-007).
  active.set(MasterFault::kBrakeSensor,
             state.brake_sensor.held(!brakes_good || brakes_disagree(config, input), input.now,
                                     config.brake_sensor_fail_time));
  // MST-005 (EV.4.7): brake and accelerator together, by the higher of the two sensors.
  active.set(MasterFault::kBrakeAndThrottle, state.brake_pressed && a.high > config.brake_throttle_limit);

  state.released = a.agree && a.high < config.pedal_release_level;
  if (state.released) state.latched = Faults{};
  state.latched.add(active);
  state.position = state.latched.any() ? Ratio{} : a.low;
  VOLTLAP_REQUIRE(a.in_range || (!a.agree && a.high == Ratio{}));
  VOLTLAP_REQUIRE(Ratio{} <= a.low && a.low <= a.high && a.high <= Ratio::from_raw(kFull));
}

}  // namespace voltlap::master
