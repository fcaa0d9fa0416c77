// SPDX-License-Identifier: Apache-2.0
// A motor as its data sheet shows it: what it takes at a torque and a speed, and the efficiency over both.
//
//   eta = tau w / P (driving), P / (tau w) (braking; 0 where the winding takes all that the shaft gives)
#pragma once
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// What a motor takes to give `shaft_nm` at `omega_rad_s`.
struct MotorPoint {
  double current_a = 0.0;
  double electrical_w = 0.0;  ///< negative when it generates
  double loss_w = 0.0;
  double efficiency = 0.0;    ///< [1] 0..1; 0 where the shaft gives and takes nothing
};
[[nodiscard]] MotorPoint motor_point(const MotorSection& motor, double shaft_nm, double omega_rad_s, double copper_c);

/// Efficiency of driving over speed (columns) and torque (rows), each in equal steps from the first above 0 to the
/// motor's last; the winding at its reference temperature. NaN above the torque curve, at the curve's voltage.
struct EfficiencyMap {
  std::vector<double> speed_rpm, torque_nm;
  std::vector<double> efficiency;  ///< [torque][speed]

  [[nodiscard]] double at(std::size_t torque, std::size_t speed) const {
    return efficiency[torque * speed_rpm.size() + speed];
  }
};
[[nodiscard]] EfficiencyMap efficiency_map(const MotorSection& motor, std::size_t speeds, std::size_t torques);

/// The numbers by which motors are chosen, at the curve's voltage.
struct MotorSummary {
  double torque_peak_nm = 0.0, power_peak_w = 0.0, speed_max_rpm = 0.0;
  double efficiency_peak = 0.0, efficiency_peak_rpm = 0.0, efficiency_peak_nm = 0.0;
};
[[nodiscard]] MotorSummary motor_summary(const MotorSection& motor);

}  // namespace voltlap::plant
