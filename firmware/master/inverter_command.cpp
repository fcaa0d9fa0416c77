// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_command.hpp"

namespace voltlap::master {

InverterCommand inverter_command(Current current, DriveState mode, const Sample<InverterState>& inverter) {
  // MST-040: enabled only when ready to drive, and only an inverter that reports itself able to work. A disabled
  // command has therefore always been sent before the first enabled one.
  const bool able = inverter.good() && (inverter.value == InverterState::kDisabled ||
                                        inverter.value == InverterState::kEnabled);
  InverterCommand command;
  command.enable = mode == DriveState::kReadyToDrive && able;
  if (!command.enable) return command;
  const std::int32_t step = kPhaseCurrentStep.raw();
  command.phase_current = Current::from_raw(current.raw() / step * step);
  return command;
}

}  // namespace voltlap::master
