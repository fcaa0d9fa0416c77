// SPDX-License-Identifier: Apache-2.0
// Friction brakes and the temperature of their rotors.
//
//   T_wheel = pedal F_caliper mu r;  two wheels an axle     m cp dT/dt = Q - h A (T - T_ambient)
// Source: reference study, 2016, Eq. 4.5-4.8 (the pads' friction does not depend on temperature there, nor here).
#pragma once
#include <cmath>

#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

struct BrakeTorques {
  double front_nm;  ///< both front wheels together
  double rear_nm;   ///< both rear wheels together
};

/// Torque that the brakes can hold at `pedal` (0..1).
[[nodiscard]] inline BrakeTorques brake_torques(const BrakeSection& b, double pedal) {
  const double per_axle = 2.0 * pedal * b.force_scale;
  return {per_axle * b.front_caliper_force_n * b.front_friction * b.front_radius_m,
          per_axle * b.rear_caliper_force_n * b.rear_friction * b.rear_radius_m};
}

/// Rotor temperatures; each rotor takes half of its axle's heat.
class BrakeRotors {
 public:
  BrakeRotors(const BrakeSection& brakes, double ambient_c)
      : brakes_(brakes), front_c_(ambient_c), rear_c_(ambient_c) {}

  void advance(double front_axle_heat_j, double rear_axle_heat_j, double elapsed_s, double ambient_c) {
    VOLTLAP_DEMAND(elapsed_s > 0.0 && std::isfinite(front_axle_heat_j) && std::isfinite(rear_axle_heat_j));
    front_c_ += change(front_axle_heat_j, front_c_ - ambient_c, brakes_.front_rotor_mass_kg,
                       brakes_.front_rotor_area_m2, elapsed_s);
    rear_c_ += change(rear_axle_heat_j, rear_c_ - ambient_c, brakes_.rear_rotor_mass_kg, brakes_.rear_rotor_area_m2,
                      elapsed_s);
  }
  [[nodiscard]] double front_c() const { return front_c_; }
  [[nodiscard]] double rear_c() const { return rear_c_; }

 private:
  [[nodiscard]] double change(double axle_heat_j, double above_ambient_k, double mass_kg, double area_m2,
                              double elapsed_s) const {
    const double cooling_j = brakes_.convection_w_per_m2_k * area_m2 * above_ambient_k * elapsed_s;
    return (0.5 * axle_heat_j - cooling_j) / (mass_kg * brakes_.rotor_heat_capacity_j_per_kg_k);
  }
  BrakeSection brakes_;
  double front_c_, rear_c_;
};

}  // namespace voltlap::plant
