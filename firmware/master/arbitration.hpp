// SPDX-License-Identifier: Apache-2.0
// Ceilings on the phase current from battery limits, the 80 kW rule and temperature; they act after the request and
// its rate limit, fall at once and rise slowly.
//
// The battery's limits are DC amperes, the command is phase current. With shaft power K |omega| I_phase, the balance is
//   I_dc V_dc eta = K |omega| I_phase   (drive; V_dc as I_dc leaves it)
//   I_dc V_dc     = K |omega| I_phase   (regeneration; losses only help)
// and I_command = min(request, ceiling) for both directions.
#pragma once
#include "master/config.hpp"
#include "master/drive_power.hpp"
#include "master/io.hpp"
#include "master/pack_sag.hpp"

namespace voltlap::master {

struct ArbitrationState {
  Current drive_ceiling{}, regen_ceiling{};  ///< as applied; all-zero memory allows nothing
  TorqueReason drive_reason = TorqueReason::kNone;
  TorqueReason regen_reason = TorqueReason::kNone;
  bool discharge_open = false;               ///< hysteresis of the battery limits
  bool charge_open = false;
  Ratio trim{};                              ///< taken off the battery and power ceilings
  Current discharge_limit_before{};          ///< what the previous command had to obey
  Speed wheels_before{};                     ///< the slowest, in the step before
  DrivePower power;
  PackSag sag;
  // Computed by arbitration_step.
  Current current{};
  TorqueReason reason = TorqueReason::kNone;
  Faults faults{};
};

/// Induced voltage K |omega| in 0.1 mV. Speed in rpm, K in uV s/rad; 2 pi / 60 = 0.1047198.
[[nodiscard]] PackVoltage induced_voltage(const Config& config, MotorSpeed speed);

/// I_dc V eta / E, from 0 to the most the inverter can do; no shaft power at standstill, hence no ceiling there.
[[nodiscard]] Current phase_current_for(const Config& config, Current dc, PackVoltage voltage, Ratio efficiency,
                                        PackVoltage induced);

/// Lowest good wheel speed; not good with fewer than two good wheels.
[[nodiscard]] Sample<Speed> lowest_wheel_speed(const Input& input);

void arbitration_step(const Config& config, const Input& input, Current request, Duration elapsed,
                      ArbitrationState& state);

}  // namespace voltlap::master
