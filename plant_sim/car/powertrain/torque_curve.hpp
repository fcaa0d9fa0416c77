// SPDX-License-Identifier: Apache-2.0
// The greatest torque of the motor over its speed. A lower bus voltage moves the curve towards lower speeds:
//
//   tau_max(w, V) = curve(w V_curve / V)        flux and voltage of a lossless machine depend on w / V alone
// A higher one moves it up, but the curve's last speed is the motor's.
// Source: motor data sheets, reference study, 2016, Table A.4; scaling: any text on field weakening.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "car/powertrain/motor.hpp"
#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

class TorqueCurve {
 public:
  explicit TorqueCurve(const MotorSection& motor) : motor_(motor) {
    const auto& rpm = motor.curve_speed_rpm;
    const auto& torque = motor.curve_torque_nm;
    VOLTLAP_DEMAND(rpm.size() >= 2 && rpm.size() == torque.size() && increasing(rpm));
    for (std::size_t i = 0; i <= kPoints; ++i) {
      const double at = rpm.back() * static_cast<double>(i) / kPoints;
      const auto above = std::upper_bound(rpm.begin() + 1, rpm.end() - 1, at);
      const auto k = static_cast<std::size_t>(above - rpm.begin());
      torque_nm_[i] = torque[k - 1] + (torque[k] - torque[k - 1]) * (at - rpm[k - 1]) / (rpm[k] - rpm[k - 1]);
    }
    points_per_speed_ = 30.0 / M_PI / rpm.back() * kPoints;
  }

  /// Greatest shaft torque [Nm] at a speed [rad/s, any sign] and a bus voltage [V]; none beyond the curve's end.
  [[nodiscard]] double torque_nm(double omega_rad_s, double dc_voltage_v) const {
    double place = std::abs(omega_rad_s) * points_per_speed_;
    if (place >= kPoints) return 0.0;
    if (motor_.curve_voltage_v > 0.0) place *= motor_.curve_voltage_v / std::max(dc_voltage_v, 1e-3);
    if (place >= kPoints) return 0.0;
    const auto i = static_cast<std::size_t>(place);
    return torque_nm_[i] + (torque_nm_[i + 1] - torque_nm_[i]) * (place - static_cast<double>(i));
  }

  /// The phase current [A] that flows when `asked_a` is commanded: no more than makes the greatest torque at the shaft,
  /// where the drag takes from a driving current and helps a braking one.
  [[nodiscard]] double current(double asked_a, double omega_rad_s, double dc_voltage_v) const {
    const double shaft = torque_nm(omega_rad_s, dc_voltage_v);
    if (shaft == 0.0) return 0.0;
    const bool driving = asked_a * omega_rad_s >= 0.0;
    const double drag = std::abs(motor_drag(motor_, omega_rad_s));
    const double before_drag = std::max(0.0, driving ? shaft + drag : shaft - drag);
    const double most = std::abs(motor_current(motor_, before_drag, driving ? 1.0 : -1.0));
    return std::clamp(asked_a, -most, most);
  }

 private:
  static constexpr std::size_t kPoints = 512;

  const MotorSection& motor_;
  double points_per_speed_ = 0.0;
  double torque_nm_[kPoints + 1] = {};
};

}  // namespace voltlap::plant
