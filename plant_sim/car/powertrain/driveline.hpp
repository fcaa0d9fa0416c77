// SPDX-License-Identifier: Apache-2.0
// Final drive: torque up, speed down, a loss in the direction of the power flow (reference study, 2016, Eq. 3.2).
#pragma once
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Torque at the rear wheels [Nm] for a torque at the motor shaft that drives (or is driven by) the wheels.
[[nodiscard]] inline double wheel_torque(const PowertrainSection& p, double shaft_torque_nm, bool driving) {
  return shaft_torque_nm * p.final_drive * (driving ? p.driveline_efficiency : 1.0 / p.driveline_efficiency);
}

/// Heat [W] of the driveline that carries the shaft power `shaft_power_w`.
[[nodiscard]] inline double driveline_loss(const PowertrainSection& p, double shaft_power_w, bool driving) {
  return shaft_power_w * (driving ? 1.0 - p.driveline_efficiency : 1.0 - 1.0 / p.driveline_efficiency);
}

}  // namespace voltlap::plant
