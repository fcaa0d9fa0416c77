// SPDX-License-Identifier: Apache-2.0
#include "car/battery/cell.hpp"

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

void Cell::look_up(CellState& state, const CellPoint& at) const {
  if (std::abs(at.current_a) > state.lookup_floor_a) state.lookup_a = std::abs(at.current_a);
  state.circuit = tables_.circuit(at.soc, at.at_c, state.lookup_a);
}

template <std::size_t N>
double Cell::advance_of(CellState& state, const CellInterval& interval, const CellPoint& end) const {
  if (std::abs(end.current_a) > state.lookup_floor_a) state.lookup_a = std::abs(end.current_a);
  const CircuitOf<N> now = tables_.circuit_of<N>(end.soc, end.at_c, state.lookup_a);
  double heat = interval.mean_square_a2() * now.r0_ohm;
  state.circuit.r0_ohm = now.r0_ohm;
  for_each_branch<N>([&](auto k) {
    const double before_s = state.circuit.tau_s[k], now_s = now.tau_s[k];
    const double tau_s = 2.0 * before_s * now_s / (before_s + now_s);
    const double u_begin = state.circuit.r_ohm[k] * interval.begin_a * tau_s / before_s;
    const double u_end = now.r_ohm[k] * interval.end_a * tau_s / now_s, from = state.v[k];
    state.v[k] = first_order_step(interval.dt_s, tau_s).after(from, u_begin, u_end);
    const double mean = first_order_mean(from, state.v[k], 0.5 * (u_begin + u_end), interval.dt_s, tau_s);
    heat += mean * mean / now.r_ohm[k];
    state.circuit.r_ohm[k] = now.r_ohm[k];
    state.circuit.tau_s[k] = now.tau_s[k];
  });
  if (has_dynamics(cell_.effects)) {
    heat += drop_of(cell_.effects, state.effects) * interval.mean_a();
    plant::advance(cell_.effects, state.effects, interval.begin_a, interval.end_a, cell_.capacity_ah, interval.dt_s);
  }
  return heat;
}

double Cell::advance(CellState& state, const CellInterval& interval, const CellPoint& end) const {
  VOLTLAP_DEMAND(interval.dt_s > 0.0);
  return with_branches(tables_.branches(), [&](auto n) { return advance_of<n>(state, interval, end); });
}

void warm(CellState& state, const CellThermal& thermal, double heat_w, double air_c, double dt_s) {
  const double before = state.temperature_c;
  state.temperature_c = temperature_after(thermal, before, heat_w, air_c, dt_s, thermal.decay(dt_s));
  state.surface_c = surface_after(state.surface_c, before, state.temperature_c, thermal.surface_lag_s, dt_s);
}

}  // namespace voltlap::plant
