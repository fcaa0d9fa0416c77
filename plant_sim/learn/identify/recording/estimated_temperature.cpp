// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/estimated_temperature.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_effects.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

double resistance_at(const HeatEstimate& heat, double temperature_c) {
  CellEffects arrhenius;
  arrhenius.activation_energy_j_per_mol = heat.activation_energy_j_per_mol;
  return heat.resistance_ohm * resistance_factor(arrhenius, 1.0, temperature_c, heat.reference_c);
}

/// At a row [W], as if its current flowed all the time.
double heat_at(const CellLog& log, const HeatEstimate& heat, std::size_t row, double temperature_c) {
  const double i = log.current_a[row];
  const double drop = heat.ocv_v.empty() ? std::nan("") : heat.ocv_v[row] - log.voltage_v[row];
  const double made = std::isfinite(drop) ? i * drop : resistance_at(heat, temperature_c) * i * i;
  return std::max(0.0, made) - i * (temperature_c + kZeroCelsius) * heat.entropy_v_per_k;
}

/// Mean of the interval that ends at a row [W].
double interval_heat(const CellLog& log, CurrentHold hold, const HeatEstimate& heat, std::size_t row,
                     double temperature_c) {
  if (log.gap[row]) return 0.0;
  if (hold == CurrentHold::kNext) return heat_at(log, heat, row, temperature_c);
  const double before = heat_at(log, heat, row - 1, temperature_c);
  return hold == CurrentHold::kPrevious ? before : 0.5 * (before + heat_at(log, heat, row, temperature_c));
}

}  // namespace

std::vector<double> estimated_temperature(const CellLog& log, CurrentHold hold, const CellThermal& thermal,
                                          const HeatEstimate& heat, const ThermalStart& start) {
  VOLTLAP_DEMAND(log.rows() > 0 && log.gap.size() == log.rows() && log.current_a.size() == log.rows());
  VOLTLAP_DEMAND(heat.ocv_v.empty() || (heat.ocv_v.size() == log.rows() && log.voltage_v.size() == log.rows()));
  VOLTLAP_DEMAND(log.ambient_c.empty() || log.ambient_c.size() == log.rows());
  VOLTLAP_DEMAND(thermal.heat_capacity_j_per_k > 0.0 && thermal.cooling_w_per_k >= 0.0 && heat.resistance_ohm >= 0.0);
  std::vector<double> out{start.cell_c};
  out.reserve(log.rows());
  double air_c = start.air_c;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    if (!log.ambient_c.empty() && std::isfinite(log.ambient_c[row - 1])) air_c = log.ambient_c[row - 1];
    const double dt_s = log.time_s[row] - log.time_s[row - 1], before_c = out.back();
    const double made_w = interval_heat(log, hold, heat, row, before_c);
    out.push_back(temperature_after(thermal, before_c, made_w, air_c, dt_s, thermal.decay(dt_s)));
  }
  return out;
}

}  // namespace voltlap::plant
