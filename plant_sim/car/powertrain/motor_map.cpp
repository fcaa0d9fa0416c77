// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/motor_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/powertrain/motor.hpp"
#include "car/powertrain/torque_curve.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRadPerS = M_PI / 30.0;  // in a turn a minute
constexpr double kUnscaled_v = 1.0;       // a curve that holds at any voltage

std::vector<double> steps_to(double last, std::size_t count) {
  std::vector<double> out;
  for (std::size_t i = 1; i <= count; ++i) out.push_back(last * static_cast<double>(i) / static_cast<double>(count));
  return out;
}

double voltage_of_curve(const MotorSection& m) { return m.curve_voltage_v > 0.0 ? m.curve_voltage_v : kUnscaled_v; }

/// [W]; between two points of the curve the power is a parabola, whose crest may lie there.
double peak_power(const MotorSection& m) {
  double most = 0.0;
  for (std::size_t i = 1; i < m.curve_speed_rpm.size(); ++i) {
    const double n0 = m.curve_speed_rpm[i - 1], n1 = m.curve_speed_rpm[i];
    const double slope = (m.curve_torque_nm[i] - m.curve_torque_nm[i - 1]) / (n1 - n0);
    const double at_rest = m.curve_torque_nm[i - 1] - slope * n0;
    const double crest = slope < 0.0 ? std::clamp(-at_rest / (2.0 * slope), n0, n1) : n1;
    most = std::max(most, (at_rest + slope * crest) * crest * kRadPerS);
  }
  return most;
}

}  // namespace

MotorPoint motor_point(const MotorSection& motor, double shaft_nm, double omega_rad_s, double copper_c) {
  VOLTLAP_DEMAND(std::isfinite(shaft_nm) && std::isfinite(omega_rad_s) && std::isfinite(copper_c));
  MotorPoint out;
  out.current_a = motor_current(motor, shaft_nm + motor_drag(motor, omega_rad_s), omega_rad_s);
  out.electrical_w = motor_power(motor, out.current_a, omega_rad_s, copper_c);
  const double shaft_w = shaft_nm * omega_rad_s;
  out.loss_w = out.electrical_w - shaft_w;
  if (shaft_w > 0.0) out.efficiency = shaft_w / out.electrical_w;
  if (shaft_w < 0.0) out.efficiency = std::max(0.0, out.electrical_w / shaft_w);
  return out;
}

EfficiencyMap efficiency_map(const MotorSection& motor, std::size_t speeds, std::size_t torques) {
  VOLTLAP_DEMAND(speeds >= 2 && torques >= 2);
  const TorqueCurve curve(motor);
  EfficiencyMap map;
  map.speed_rpm = steps_to(motor.curve_speed_rpm.back(), speeds);
  map.torque_nm = steps_to(*std::max_element(motor.curve_torque_nm.begin(), motor.curve_torque_nm.end()), torques);
  for (const double torque : map.torque_nm) {
    for (const double speed : map.speed_rpm) {
      const double omega = speed * kRadPerS;
      const bool reached = torque <= curve.torque_nm(omega, voltage_of_curve(motor)) * (1.0 + 1e-9);
      map.efficiency.push_back(reached ? motor_point(motor, torque, omega, motor.winding_reference_c).efficiency
                                       : std::numeric_limits<double>::quiet_NaN());
    }
  }
  VOLTLAP_DEMAND(map.efficiency.size() == speeds * torques);
  return map;
}

MotorSummary motor_summary(const MotorSection& motor) {
  constexpr std::size_t kSpeeds = 400, kTorques = 200;
  const EfficiencyMap map = efficiency_map(motor, kSpeeds, kTorques);
  MotorSummary out;
  out.torque_peak_nm = map.torque_nm.back();
  out.speed_max_rpm = map.speed_rpm.back();
  for (std::size_t s = 0; s < kSpeeds; ++s) {
    for (std::size_t t = 0; t < kTorques; ++t) {
      if (!(map.at(t, s) > out.efficiency_peak)) continue;
      out.efficiency_peak = map.at(t, s);
      out.efficiency_peak_rpm = map.speed_rpm[s];
      out.efficiency_peak_nm = map.torque_nm[t];
    }
  }
  out.power_peak_w = peak_power(motor);
  VOLTLAP_DEMAND(within(out.efficiency_peak, 0.0, 1.0) && out.speed_max_rpm > 0.0);
  return out;
}

}  // namespace voltlap::plant
