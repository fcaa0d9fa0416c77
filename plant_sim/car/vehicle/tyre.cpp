// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/tyre.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

constexpr double kLinearSlip = 1e-9;  // below it force over slip is the slope at zero

}  // namespace

TyreForce tyre_force(const TyreSection& tyre, double slip, double normal_n) {
  const double bk = tyre.pacejka_b * slip;
  const double inner = bk - tyre.pacejka_e * (bk - std::atan(bk));
  const double angle = tyre.pacejka_c * std::atan(inner);
  const double inner_slope = tyre.pacejka_b * (1.0 - tyre.pacejka_e * (1.0 - 1.0 / (1.0 + bk * bk)));
  const double peak = normal_n * tyre.pacejka_d;
  return {peak * std::sin(angle), peak * std::cos(angle) * tyre.pacejka_c / (1.0 + inner * inner) * inner_slope};
}

AxleStep axle_step(const TyreSection& tyre, const AxleInput& in, double omega_rad_s, double step_s) {
  const double r = tyre.radius_m;
  const double reference = std::max(std::abs(in.speed_mps), tyre.slip_speed_floor_mps);
  const double slip = (r * omega_rad_s - in.speed_mps) / reference;
  const TyreForce tyre_now = tyre_force(tyre, slip, in.normal_n);
  // The secant F/k is never below the slope: with it a free wheel's speed error shrinks without changing sign. With the
  // slope alone, which vanishes at the peak, a step near standstill jumps to the other peak and back for ever.
  const double secant = std::abs(slip) > kLinearSlip ? tyre_now.force_n / slip : tyre_now.slope_n;
  const double stiffness = secant / reference;
  const double inertia = in.inertia_kg_m2 + step_s * r * r * stiffness;

  const double free = omega_rad_s + step_s * (in.drive_torque_nm - r * tyre_now.force_n) / inertia;
  const double brake_most = step_s * in.brake_torque_nm / inertia;
  const bool holds = std::abs(free) <= brake_most;
  const double next = holds ? 0.0 : free - std::copysign(brake_most, free);

  AxleStep out;
  out.omega_rad_s = next;
  out.omega_mean_rad_s = 0.5 * (omega_rad_s + next);
  out.force_n = tyre_now.force_n + stiffness * r * (next - omega_rad_s);
  out.brake_torque_nm = holds ? free * inertia / step_s : std::copysign(in.brake_torque_nm, free);
  return out;
}

}  // namespace voltlap::plant
