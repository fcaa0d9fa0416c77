// SPDX-License-Identifier: Apache-2.0
#include "car/battery/cell.hpp"

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

void Cell::look_up(CellState& state, const CellPoint& at) const {
  if (std::abs(at.current_a) > state.lookup_floor_a) state.lookup_a = std::abs(at.current_a);
  state.circuit = tables_.circuit(at.soc, at.at_c, state.lookup_a);
}

double Cell::advance(CellState& state, const CellInterval& interval, const CellPoint& end) const {
  VOLTLAP_DEMAND(interval.dt_s > 0.0);
  const CircuitParameters before = state.circuit;
  look_up(state, end);
  const CircuitParameters& now = state.circuit;
  const auto branch = [&](double& v, double r_begin, double r_end, double tau_s) {
    const double u_begin = r_begin * interval.begin_a, u_end = r_end * interval.end_a, from = v;
    v = first_order_step(interval.dt_s, tau_s).after(from, u_begin, u_end);
    return first_order_mean(from, v, 0.5 * (u_begin + u_end), interval.dt_s, tau_s);
  };
  const double mean1 = branch(state.v1, before.r1_ohm, now.r1_ohm, 0.5 * (before.tau1_s + now.tau1_s));
  const double mean2 = branch(state.v2, before.r2_ohm, now.r2_ohm, 0.5 * (before.tau2_s + now.tau2_s));
  double heat = interval.mean_square_a2() * now.r0_ohm + mean1 * mean1 / now.r1_ohm + mean2 * mean2 / now.r2_ohm;
  if (has_dynamics(cell_.effects)) {
    heat += drop_of(cell_.effects, state.effects) * interval.mean_a();
    plant::advance(cell_.effects, state.effects, interval.begin_a, interval.end_a, cell_.capacity_ah, interval.dt_s);
  }
  return heat;
}

void warm(CellState& state, const CellThermal& thermal, double heat_w, double air_c, double dt_s) {
  const double before = state.temperature_c;
  state.temperature_c = temperature_after(thermal, before, heat_w, air_c, dt_s, thermal.decay(dt_s));
  state.surface_c = surface_after(state.surface_c, before, state.temperature_c, thermal.surface_lag_s, dt_s);
}

}  // namespace voltlap::plant
