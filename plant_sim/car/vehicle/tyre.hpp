// SPDX-License-Identifier: Apache-2.0
// Longitudinal tyre force by the magic formula, and one axle's wheel speed by a step that stays stable at standstill.
//
//   F(k) = N D sin(C atan(B k - E (B k - atan(B k)))),   k = (r w - V) / max(|V|, V_floor)
// Source: reference study, 2016, Eq. 4.1 and 4.2. The floor in the slip ratio and the linearly implicit step (implicit
// Euler in w with the secant F/k for the force) replace an explicit step, which diverges below about 1.3 m/s at 1 ms.
#pragma once
#include "core/parameters.hpp"

namespace voltlap::plant {

struct TyreForce {
  double force_n;
  double slope_n;  ///< dF/dk [N]
};

/// Force of an axle whose tyres carry `normal_n` together. `slip` is k, any value.
[[nodiscard]] TyreForce tyre_force(const TyreSection& tyre, double slip, double normal_n);

struct AxleInput {
  double speed_mps;       ///< of the vehicle, V
  double normal_n;        ///< both tyres
  double drive_torque_nm; ///< at the wheels, positive drives forward
  double brake_torque_nm; ///< both brakes, magnitude they can hold, >= 0
  double inertia_kg_m2;
};

struct AxleStep {
  double omega_rad_s;       ///< at the end of the step
  double omega_mean_rad_s;  ///< over the step
  double force_n;           ///< of the tyres on the car, forward positive
  double brake_torque_nm;   ///< that acted, sign of the rotation
};

/// One step of I dw/dt = T_drive - T_brake - r F(k). Brakes are Coulomb friction: they stop a wheel and hold it.
[[nodiscard]] AxleStep axle_step(const TyreSection& tyre, const AxleInput& in, double omega_rad_s, double step_s);

}  // namespace voltlap::plant
