// SPDX-License-Identifier: Apache-2.0
// The command in steps that the wire can carry, and whether the output stage may be on.
#pragma once
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct InverterCommand {
  Current phase_current{};
  bool enable = false;
  Current limit{};  ///< the ceiling in its direction, for an inverter that takes one
  WheelCurrents wheel{};  ///< what each of four has of it
};

/// Step of the phase current on the bus: 0.1 A. Cut towards zero, so that rounding never passes a ceiling.
inline constexpr Current kPhaseCurrentStep = Current::from_raw(100);

[[nodiscard]] InverterCommand inverter_command(Current current, DriveState mode, const Sample<InverterState>& inverter);
/// The same for four inverters, of which none has torque before all obey.
[[nodiscard]] InverterCommand wheel_command(const Config& config, const InverterCommand& all,
                                            const Sample<InverterState>& worst);

}  // namespace voltlap::master
