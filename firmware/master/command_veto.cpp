// SPDX-License-Identifier: Apache-2.0
#include "master/command_veto.hpp"

namespace voltlap::master {
namespace {

// Judged by the sample's own time, so that a receiver that forgets to age its samples is caught here.
template <class T>
bool fresh(const Config& config, const Input& input, const Sample<T>& sample) {
  const Duration age = input.now - sample.time;
  return sample.good() && age >= Duration{} && age < config.rx_timeout;
}

// MST-051: four currents that together are the command, none in another direction, beyond its motor or before all obey.
bool wheels_lawful(const Config& config, const Input& input, const InverterCommand& command) {
  const Current all = command.phase_current;
  if (command.wheel.sum() != all) return false;
  if (all != Current{} && input.inverter_state.value != InverterState::kEnabled) return false;
  for (const Current current : command.wheel.of) {
    if (current > config.motor_current_max || current < -config.motor_current_max) return false;
    if (all >= Current{} ? current < Current{} : current > Current{}) return false;
  }
  return true;
}

bool pressed(const AppsChannel& channel, const Sample<Potential>& apps) { return apps.value > channel.released; }

}  // namespace

bool command_allowed(const Config& config, const Input& input, const InverterCommand& command) {
  if (!command.enable) {
    for (const Current current : command.wheel.of) {
      if (current != Current{}) return false;
    }
    return command.phase_current == Current{};
  }
  // MST-050: nothing older than 50 ms carries torque.
  const bool all_fresh = fresh(config, input, input.apps1) && fresh(config, input, input.apps2) &&
                         fresh(config, input, input.inverter_state) && fresh(config, input, input.switches) &&
                         fresh(config, input, input.bms_state) && fresh(config, input, input.discharge_limit) &&
                         fresh(config, input, input.charge_limit);
  if (!all_fresh || !input.switches.value.shutdown_closed || input.bms_state.value != BmsState::kTsActive) return false;

  // MST-051: never beyond the inverter's range, against a closed battery, or without the driver's foot.
  const Current current = command.phase_current;
  if (current > config.phase_current_max || current < -config.phase_current_max) return false;
  if (config.inverter_protocol == InverterProtocol::kPm100) {
    const Current limit = command.limit;
    if (limit > config.phase_current_max || current > limit || current < -limit) return false;
  }
  if (config.inverter_protocol == InverterProtocol::kAmk && !wheels_lawful(config, input, command)) return false;
  if (current > Current{}) {
    return input.discharge_limit.value > Current{} && pressed(config.apps1, input.apps1) &&
           pressed(config.apps2, input.apps2);
  }
  return current == Current{} || input.charge_limit.value > Current{};
}

}  // namespace voltlap::master
