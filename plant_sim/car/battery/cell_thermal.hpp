// SPDX-License-Identifier: Apache-2.0
// Temperature of a cell from its heat, and of the surface that a thermistor sits on.
//
//   m cp dT/dt = P - h A (T - T_air)      exact for constant P and T_air; without cooling the heat adds up
//   L dT_s/dt = T - T_s                   exact for a T that goes straight
// Source: reference study, 2016, Eq. 7.7.
#pragma once
#include <cmath>

#include "car/battery/first_order.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// What keeps a cell's heat and what lets it out.
struct CellThermal {
  double heat_capacity_j_per_k, cooling_w_per_k, surface_lag_s;

  /// What is left of a difference from the air after `dt_s`.
  [[nodiscard]] double decay(double dt_s) const { return std::exp(-dt_s * cooling_w_per_k / heat_capacity_j_per_k); }
};

[[nodiscard]] inline CellThermal thermal_of(const CellParameters& cell) {
  return {cell.mass_kg * cell.heat_capacity_j_per_kg_k, cell.convection_w_per_m2_k * cell.surface_area_m2,
          cell.surface_lag_s};
}

/// Temperature [degC] after `dt_s` of `heat_w` at `decay` = thermal.decay(dt_s).
[[nodiscard]] inline double temperature_after(const CellThermal& thermal, double temperature_c, double heat_w,
                                              double air_c, double dt_s, double decay) {
  const double above = heat_w / thermal.cooling_w_per_k;
  return thermal.cooling_w_per_k > 0.0 ? air_c + above + (temperature_c - air_c - above) * decay
                                       : temperature_c + heat_w * dt_s / thermal.heat_capacity_j_per_k;
}

/// Temperature of the surface [degC] after a step in which the cell's goes straight from `begin_c` to `end_c`.
[[nodiscard]] inline double surface_after(double surface_c, double begin_c, double end_c, double lag_s, double dt_s) {
  if (lag_s <= 0.0 || dt_s <= 0.0) return end_c;
  return first_order_step(dt_s, lag_s).after(surface_c, begin_c, end_c);
}

}  // namespace voltlap::plant
