// SPDX-License-Identifier: Apache-2.0
// What a cell does beyond its branches and tables; every effect is off (0) unless a cell file or an explanation of
// a log switches it on.
//
//   R0, R1 ..    times exp(Ea/Rg (1/T - 1/T_ref)) (1 + l max(0, 1 - SOC/0.3))      Arrhenius; low end
//   R0           plus R_s, plus dv_ct(|I|)/|I| with v_ct(I) = 4 Rg T/F asinh(I / 2 i0)
//                dv_ct: change when i0 becomes i0 (1 + x)                 Butler-Volmer, two electrodes alike
//                i0: the one that bends R0 over the currents of the tables; of one current only, 2 Rg T / (F R1)
//   OCV          plus a polygon over SOC, plus (T - T_ref) dOCV/dT
//   branches     dv/dt = (R I - v)/tau, two more
//   hysteresis   V -= M h,  dh/dSOC_drawn = g |I|/I (1 - h sign(I))                   Plett, 2004, one state
//   heat         minus I T dOCV/dT                                                    Bernardi, 1985
#pragma once
#include <algorithm>
#include <cmath>

#include "car/battery/first_order.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

inline constexpr double kGasConstant = 8.314462618;  // J/mol/K
inline constexpr double kFaraday = 96485.33212;      // C/mol
inline constexpr double kZeroCelsius = 273.15;       // K
inline constexpr double kLowEnd = 0.3;               // SOC; above it the low end's change is none

/// Factor of a resistance or time constant with this activation energy between two temperatures.
[[nodiscard]] inline double arrhenius(double j_per_mol, double temperature_c, double reference_c) {
  const double inverse = 1.0 / (temperature_c + kZeroCelsius) - 1.0 / (reference_c + kZeroCelsius);
  return std::exp(j_per_mol / kGasConstant * inverse);
}

[[nodiscard]] inline double resistance_factor(const CellEffects& e, double soc, double temperature_c,
                                              double reference_c) {
  const double energy = e.activation_energy_j_per_mol;
  const double factor = energy != 0.0 ? arrhenius(energy, temperature_c, reference_c) : 1.0;
  return factor * (1.0 + e.low_end_change * std::max(0.0, 1.0 - soc / kLowEnd));
}

/// Volts that the charge transfer of both electrodes takes.
[[nodiscard]] inline double charge_transfer_v(double exchange_a, double current_a, double temperature_c) {
  const double thermal_v = kGasConstant * (temperature_c + kZeroCelsius) / kFaraday;
  return 4.0 * thermal_v * std::asinh(current_a / (2.0 * exchange_a));
}

/// Ohms that R0 gains at |I| = `current_a` when this exchange current changes.
[[nodiscard]] inline double charge_transfer_change(const CellEffects& e, double exchange_a, double current_a,
                                                   double temperature_c) {
  if (e.exchange_current_change == 0.0) return 0.0;
  const double current = std::max(current_a, 1e-3 * exchange_a);
  return (charge_transfer_v(exchange_a * (1.0 + e.exchange_current_change), current, temperature_c) -
          charge_transfer_v(exchange_a, current, temperature_c)) / current;
}

/// The hysteresis state after a share of the charge was drawn; negative: put back.
[[nodiscard]] inline double hysteresis_after(double before, double per_soc, double soc_drawn) {
  const double side = soc_drawn > 0.0 ? 1.0 : -1.0;
  return side + (before - side) * std::exp(-per_soc * std::abs(soc_drawn));
}
/// Where nothing is known of what came before: that after a charge for a cell that is full, else between the two.
[[nodiscard]] inline double hysteresis_at_begin(double soc) {
  constexpr double kFull = 0.98;
  return soc > kFull ? -1.0 : 0.0;
}

/// State of the dynamic effects of one cell [V]; `hysteresis` in -1..1, 1 after a long discharge.
struct CellEffectState {
  double polarization_v = 0.0, slow_relaxation_v = 0.0, hysteresis = 0.0;
};

[[nodiscard]] inline bool has_dynamics(const CellEffects& e) {
  return e.polarization_ohm != 0.0 || e.slow_relaxation_ohm != 0.0 || e.hysteresis_v != 0.0;
}

/// Volts that the dynamic effects take from the cell.
[[nodiscard]] inline double drop_of(const CellEffects& e, const CellEffectState& s) {
  return s.polarization_v + s.slow_relaxation_v + e.hysteresis_v * s.hysteresis;
}

/// Exact over a step whose current [A] is straight from `begin_a` to `end_a` for the branches; the hysteresis takes
/// the mean.
inline void advance(const CellEffects& e, CellEffectState& s, double begin_a, double end_a, double capacity_ah,
                    double dt_s) {
  const auto branch = [&](double& v, double ohm, double tau_s) {
    v = first_order_step(dt_s, tau_s).after(v, ohm * begin_a, ohm * end_a);
  };
  if (e.polarization_ohm != 0.0) branch(s.polarization_v, e.polarization_ohm, e.polarization_tau_s);
  if (e.slow_relaxation_ohm != 0.0) branch(s.slow_relaxation_v, e.slow_relaxation_ohm, e.slow_relaxation_tau_s);
  if (e.hysteresis_v != 0.0) {
    const double drawn = 0.5 * (begin_a + end_a) * dt_s / (3600.0 * capacity_ah);
    s.hysteresis = hysteresis_after(s.hysteresis, e.hysteresis_per_soc, drawn);
  }
}

/// Volts that the OCV gains by the temperature.
[[nodiscard]] inline double reversible_voltage(const CellEffects& e, double temperature_c, double reference_c) {
  return e.entropy_v_per_k * (temperature_c - reference_c);
}

/// Reversible heat [W] at discharge current `current_a`.
[[nodiscard]] inline double reversible_heat(const CellEffects& e, double current_a, double temperature_c) {
  return -current_a * (temperature_c + kZeroCelsius) * e.entropy_v_per_k;
}

}  // namespace voltlap::plant
