// SPDX-License-Identifier: Apache-2.0
// The motor as a DC machine with an efficiency, and the chain of masses that its loss heats.
//
//   tau = K I eta (driving), K I / eta (braking);  V = K w (+ R I with `winding_loss`)
//   copper -> insulation -> steel -> aluminium -> air, each a lumped mass
// Source: reference study, 2016, Eq. 4.15-4.17 (4.16 printed inverted), Fig. 4.24, Table B.5.
#pragma once
#include <cmath>

#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Shaft torque [Nm] at phase current `current_a`; `omega` decides whether the machine drives or brakes.
[[nodiscard]] inline double motor_torque(const MotorSection& m, double current_a, double omega_rad_s) {
  const double ideal = m.constant_nm_per_a * current_a;
  return ideal * omega_rad_s >= 0.0 ? ideal * m.efficiency : ideal / m.efficiency;
}

/// Loss [W] that heats the motor, from the efficiency (Eq. 4.17) and the winding. `driving` as `motor_torque` chose it.
[[nodiscard]] inline double motor_loss(const MotorSection& m, double current_a, double omega_rad_s, bool driving) {
  const double electrical = m.constant_nm_per_a * omega_rad_s * current_a;
  const double winding = m.winding_loss ? m.winding_resistance_ohm * current_a * current_a : 0.0;
  return (driving ? electrical * (1.0 - m.efficiency) : electrical * (1.0 - 1.0 / m.efficiency)) + winding;
}

/// Electrical power into the motor [W], negative when it generates.
[[nodiscard]] inline double motor_power(const MotorSection& m, double current_a, double omega_rad_s) {
  const double winding = m.winding_loss ? m.winding_resistance_ohm * current_a * current_a : 0.0;
  return m.constant_nm_per_a * omega_rad_s * current_a + winding;
}

class MotorThermal {
 public:
  MotorThermal(const MotorSection& motor, double ambient_c)
      : motor_(motor), copper_(ambient_c), steel_(ambient_c), aluminium_(ambient_c) {}

  /// Explicit step; the quickest mode of the chain is about 0.2 s, so steps of 10 ms are far inside stability.
  void advance(double heat_j, double elapsed_s, double ambient_c) {
    VOLTLAP_DEMAND(elapsed_s > 0.0 && std::isfinite(heat_j));
    const MotorSection& m = motor_;
    const double to_steel = m.insulation_conductance_w_per_k * (copper_ - steel_);
    const double to_aluminium = m.steel_conductance_w_per_k * (steel_ - aluminium_);
    const double convection = m.convection_w_per_m2_k * m.surface_area_m2;
    const double to_air = m.aluminium_conductance_w_per_k * convection /
                          (m.aluminium_conductance_w_per_k + convection) * (aluminium_ - ambient_c);
    copper_ += (heat_j - to_steel * elapsed_s) / (m.copper_mass_kg * m.copper_heat_capacity_j_per_kg_k);
    steel_ += (to_steel - to_aluminium) * elapsed_s / (m.steel_mass_kg * m.steel_heat_capacity_j_per_kg_k);
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
