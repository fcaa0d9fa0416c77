// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_command.hpp"

#include "master/torque_split.hpp"

namespace voltlap::master {

InverterCommand inverter_command(Current current, DriveState mode, const Sample<InverterState>& inverter) {
  // MST-040: enabled only when ready to drive, and only an inverter that reports itself able to work. A disabled
  // command has therefore always been sent before the first enabled one.
  const bool able = inverter.good() && (inverter.value == InverterState::kDisabled ||
                                        inverter.value == InverterState::kEnabled);
  InverterCommand command;
  command.enable = mode == DriveState::kReadyToDrive && able;
  const std::int32_t step = kPhaseCurrentStep.raw();
  if (command.enable) command.phase_current = Current::from_raw(current.raw() / step * step);
  return command;
}

// MST-068: setpoints are zero until every inverter has reported the end of its sequence.
InverterCommand wheel_command(const Config& config, const InverterCommand& all, const Sample<InverterState>& worst) {
  const bool obeyed = worst.good() && worst.value == InverterState::kEnabled;
  InverterCommand command = all;
  command.wheel = split_torque(config, all.enable && obeyed ? all.phase_current : Current{});
  command.phase_current = command.wheel.sum();
  return command;
}

}  // namespace voltlap::master
