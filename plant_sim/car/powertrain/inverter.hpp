// SPDX-License-Identifier: Apache-2.0
// The inverter: follows a phase-current command, stops when the command falls silent or the DC link is too low.
//
//   P_dc = P_motor / eta (driving), P_motor eta (braking)      reference study, 2016, Eq. 4.14
#pragma once
#include <algorithm>

#include "core/parameters.hpp"

namespace voltlap::plant {

enum class InverterState { kOff, kDisabled, kEnabled, kCommandTimeout };

class Inverter {
 public:
  explicit Inverter(const InverterSection& inverter) : inverter_(inverter), silence_s_(inverter.command_timeout_s) {}

  /// A valid command arrived.
  void command(double current_a, bool enable) {
    command_a_ = std::clamp(current_a, -inverter_.current_max_a, inverter_.current_max_a);
    enable_ = enable;
    silence_s_ = 0.0;
  }
  /// Time passes; call once a control period before `current`.
  void advance(double elapsed_s) { silence_s_ += elapsed_s; }

  [[nodiscard]] InverterState state(double dc_voltage_v) const {
    if (dc_voltage_v < inverter_.dc_voltage_min_v) return InverterState::kOff;
    if (silence_s_ > inverter_.command_timeout_s) return InverterState::kCommandTimeout;
    return enable_ ? InverterState::kEnabled : InverterState::kDisabled;
  }
  /// Phase current [A] that it drives now.
  [[nodiscard]] double current(double dc_voltage_v) const {
    return state(dc_voltage_v) == InverterState::kEnabled ? command_a_ : 0.0;
  }
  /// Power taken from the DC link [W] to feed the motor with `motor_power_w`.
  [[nodiscard]] double dc_power(double motor_power_w) const {
    return motor_power_w >= 0.0 ? motor_power_w / inverter_.efficiency : motor_power_w * inverter_.efficiency;
  }

  /// Its own heat [W] at that motor power.
  [[nodiscard]] double loss(double motor_power_w) const {
    return motor_power_w >= 0.0 ? motor_power_w * (1.0 / inverter_.efficiency - 1.0)
                                : -motor_power_w * (1.0 - inverter_.efficiency);
  }

 private:
  InverterSection inverter_;
  double command_a_ = 0.0, silence_s_;
  bool enable_ = false;
};

}  // namespace voltlap::plant
