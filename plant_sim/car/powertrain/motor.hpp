// SPDX-License-Identifier: Apache-2.0
// The motor as a DC machine with losses, and the chain of masses that they heat.
//
//   tau = K I eta (driving), K I / eta (braking);  V = K w (+ R I with `winding_loss`)
//   R = R_ref (1 + alpha (T_copper - T_ref))
//   tau_shaft = tau - tau_drag,  tau_drag = k_h sgn w + k_e w + k_w w |w|      with no current, too
//   copper -> insulation -> steel -> aluminium -> air, each a lumped mass; the drag heats the steel
//
//   k_h  Nm      hysteresis of the iron, P = k_h |w|; friction of the bearings has the same form
//   k_e  Nm s    eddy currents of iron and magnets, P = k_e w^2
//   k_w  Nm s2   air about the rotor, P = k_w |w|^3
// An efficiency map of a data sheet tells R from what grows with the torque, k_h, k_e and k_w from what is there
// without; eta is for what is left, or for a motor of which only a share is known.
// Source: reference study, 2016, Eq. 4.15-4.17 (4.16 printed inverted), Fig. 4.24, Table B.5; iron losses at a flux
// that does not change: Steinmetz 1892, Bertotti 1988; air: Pyrhonen, Jokinen, Hrabovcova, Design of Rotating
// Electrical Machines, section 9.1.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Torque [Nm] that the phase current `current_a` makes, before the drag; `omega` decides whether the machine drives or
/// brakes.
[[nodiscard]] inline double motor_torque(const MotorSection& m, double current_a, double omega_rad_s) {
  const double ideal = m.constant_nm_per_a * current_a;
  return ideal * omega_rad_s >= 0.0 ? ideal * m.efficiency : ideal / m.efficiency;
}

/// The phase current [A] that makes `torque_nm`, before the drag: the inverse of `motor_torque`.
[[nodiscard]] inline double motor_current(const MotorSection& m, double torque_nm, double omega_rad_s) {
  const bool driving = torque_nm * omega_rad_s >= 0.0;
  return torque_nm / (m.constant_nm_per_a * (driving ? m.efficiency : 1.0 / m.efficiency));
}

/// Torque [Nm] against the rotation, signed with it. Below 1 rad/s hysteresis falls linearly to zero, so that it does
/// not turn a standing motor.
[[nodiscard]] inline double motor_drag(const MotorSection& m, double omega_rad_s) {
  constexpr double kFade_rad_s = 1.0;
  return m.drag_hysteresis_nm * std::clamp(omega_rad_s / kFade_rad_s, -1.0, 1.0) +
         (m.drag_eddy_nm_s + m.drag_windage_nm_s2 * std::abs(omega_rad_s)) * omega_rad_s;
}

/// Resistance [ohm] with which the current heats the winding; 0 without `winding_loss`.
[[nodiscard]] inline double winding_resistance(const MotorSection& m, double copper_c) {
  return m.winding_loss ? m.winding_resistance_ohm * (1.0 + m.winding_per_kelvin * (copper_c - m.winding_reference_c))
                        : 0.0;
}

/// Loss [W] that the current makes, from the efficiency (Eq. 4.17) and the winding. `driving` as `motor_torque` chose.
[[nodiscard]] inline double motor_loss(const MotorSection& m, double current_a, double omega_rad_s, bool driving,
                                       double copper_c) {
  const double electrical = m.constant_nm_per_a * omega_rad_s * current_a;
  const double winding = winding_resistance(m, copper_c) * current_a * current_a;
  return (driving ? electrical * (1.0 - m.efficiency) : electrical * (1.0 - 1.0 / m.efficiency)) + winding;
}

/// Electrical power into the motor [W], negative when it generates.
[[nodiscard]] inline double motor_power(const MotorSection& m, double current_a, double omega_rad_s, double copper_c) {
  const double winding = winding_resistance(m, copper_c) * current_a * current_a;
  return m.constant_nm_per_a * omega_rad_s * current_a + winding;
}

/// Both with the winding at its reference temperature.
[[nodiscard]] inline double motor_loss(const MotorSection& m, double current_a, double omega_rad_s, bool driving) {
  return motor_loss(m, current_a, omega_rad_s, driving, m.winding_reference_c);
}
[[nodiscard]] inline double motor_power(const MotorSection& m, double current_a, double omega_rad_s) {
  return motor_power(m, current_a, omega_rad_s, m.winding_reference_c);
}

class MotorThermal {
 public:
  MotorThermal(const MotorSection& motor, double ambient_c)
      : motor_(motor), copper_(ambient_c), steel_(ambient_c), aluminium_(ambient_c) {}

  /// Explicit step; the quickest mode of the chain is about 0.2 s, so steps of 10 ms are far inside stability. Heat of
  /// the current comes in the copper, that of the drag in the steel.
  void advance(double copper_heat_j, double elapsed_s, double ambient_c, double steel_heat_j = 0.0) {
    VOLTLAP_DEMAND(elapsed_s > 0.0 && std::isfinite(copper_heat_j) && std::isfinite(steel_heat_j));
    const MotorSection& m = motor_;
    const double to_steel = m.insulation_conductance_w_per_k * (copper_ - steel_);
    const double to_aluminium = m.steel_conductance_w_per_k * (steel_ - aluminium_);
    const double convection = m.convection_w_per_m2_k * m.surface_area_m2;
    const double to_air = m.aluminium_conductance_w_per_k * convection /
                          (m.aluminium_conductance_w_per_k + convection) * (aluminium_ - ambient_c);
    copper_ += (copper_heat_j - to_steel * elapsed_s) / (m.copper_mass_kg * m.copper_heat_capacity_j_per_kg_k);
    steel_ += (steel_heat_j + (to_steel - to_aluminium) * elapsed_s) /
              (m.steel_mass_kg * m.steel_heat_capacity_j_per_kg_k);
    aluminium_ += (to_aluminium - to_air) * elapsed_s / (m.aluminium_mass_kg * m.aluminium_heat_capacity_j_per_kg_k);
  }
  [[nodiscard]] double copper_c() const { return copper_; }
  [[nodiscard]] double steel_c() const { return steel_; }
  [[nodiscard]] double aluminium_c() const { return aluminium_; }

 private:
  MotorSection motor_;
  double copper_, steel_, aluminium_;
};

}  // namespace voltlap::plant
