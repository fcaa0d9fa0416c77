// SPDX-License-Identifier: Apache-2.0
// The inverter: follows a phase-current command, stops when the command falls silent or the DC link is too low.
//
//   P_dc = P_motor / eta (driving), P_motor eta (braking)      reference study, 2016, Eq. 4.14
//        + P_0 + a |I| + b I^2 + c V |I|                       while the output stage is on
//
//   P_0  W       gate drivers, and switching at no current
//   a    W/A     threshold voltage of IGBTs and diodes, by phase current
//   b    W/A2    resistance of MOSFETs and bars
//   c    W/V/A   switching: (E_on + E_off) f / (V I) of the data sheet, times the switches that share the current
// Currents as the motor's constant counts them. Source: any application note on losses of power modules, e.g.
// Graovac and Puerschel, IGBT Power Losses Calculation Using the Data-Sheet Parameters, Infineon, 2009.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/parameters.hpp"

namespace voltlap::plant {

enum class InverterState { kOff, kDisabled, kEnabled, kCommandTimeout };

/// Power taken from the DC link [W] to feed the motor with `motor_power_w`, by the efficiency alone.
[[nodiscard]] inline double inverter_dc_power(const InverterSection& inverter, double motor_power_w) {
  return motor_power_w >= 0.0 ? motor_power_w / inverter.efficiency : motor_power_w * inverter.efficiency;
}

/// Loss [W] beside that, of an output stage that is on.
[[nodiscard]] inline double inverter_stage_loss(const InverterSection& inverter, double phase_current_a,
                                                double dc_voltage_v) {
  const double current = std::abs(phase_current_a);
  return inverter.loss_w +
         (inverter.loss_w_per_a + inverter.loss_w_per_a2 * current + inverter.loss_w_per_v_a * dc_voltage_v) * current;
}

class Inverter {
 public:
  explicit Inverter(const InverterSection& inverter) : inverter_(inverter), silence_s_(inverter.command_timeout_s) {}

  /// A valid command arrived.
  void command(double current_a, bool enable) {
    silence_s_ = 0.0;
    if (stuck_) return;
    command_a_ = std::clamp(current_a, -inverter_.current_max_a, inverter_.current_max_a);
    enable_ = enable;
  }
  /// Time passes; call once a control period before `current`.
  void advance(double elapsed_s) { silence_s_ = stuck_ ? 0.0 : silence_s_ + elapsed_s; }

  /// Planted faults. Stuck: it goes on with what it was last told, whatever comes and whether anything comes.
  void set_stuck(bool stuck) { stuck_ = stuck; }
  /// It gives this share of the current that it is asked for; 1 without fault.
  void set_share(double share) { share_ = share; }

  [[nodiscard]] InverterState state(double dc_voltage_v) const {
    if (dc_voltage_v < inverter_.dc_voltage_min_v) return InverterState::kOff;
    if (silence_s_ > inverter_.command_timeout_s) return InverterState::kCommandTimeout;
    return enable_ ? InverterState::kEnabled : InverterState::kDisabled;
  }
  /// Phase current [A] that it drives now.
  [[nodiscard]] double current(double dc_voltage_v) const {
    return state(dc_voltage_v) == InverterState::kEnabled ? command_a_ * share_ : 0.0;
  }
  /// Power taken from the DC link [W] to feed the motor with `motor_power_w`, by the efficiency alone.
  [[nodiscard]] double dc_power(double motor_power_w) const { return inverter_dc_power(inverter_, motor_power_w); }

  /// Loss [W] beside that, none while the output stage is off.
  [[nodiscard]] double stage_loss(double phase_current_a, double dc_voltage_v) const {
    if (state(dc_voltage_v) != InverterState::kEnabled) return 0.0;
    return inverter_stage_loss(inverter_, phase_current_a, dc_voltage_v);
  }

  /// Its own heat [W] at that motor power, by the efficiency alone.
  [[nodiscard]] double loss(double motor_power_w) const {
    return motor_power_w >= 0.0 ? motor_power_w * (1.0 / inverter_.efficiency - 1.0)
                                : -motor_power_w * (1.0 - inverter_.efficiency);
  }

 private:
  InverterSection inverter_;
  double command_a_ = 0.0, silence_s_;
  double share_ = 1.0;
  bool enable_ = false, stuck_ = false;
};

}  // namespace voltlap::plant
