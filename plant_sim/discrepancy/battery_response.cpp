// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/battery_response.hpp"

#include <algorithm>
#include <cmath>

#include "battery/cell_effects.hpp"
#include "battery/cell_tables.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The current that flowed, from what its sensor said; a missing reading counts as the one before.
VectorXd true_current(const World& world, const Recording& log, const VectorXd& raw) {
  VectorXd out = raw;
  double last = 0.0;
  for (Index row = 0; row < out.size(); ++row) {
    if (!std::isfinite(out(row))) out(row) = last;
    last = out(row);
  }
  if (world.current.delay_s != 0.0) out = shifted(log.time_s, out, world.current.delay_s);
  for (Index row = 0; row < out.size(); ++row) {
    const bool clipped = world.current_limit_a > 0.0 && std::abs(raw(row)) >= world.current_limit_a;
    out(row) = (out(row) - world.current.offset) / (1.0 + world.current.gain);
    if (clipped) out(row) += std::copysign(world.current_beyond_limit_a, raw(row));
  }
  return out / world.car.battery.cells_in_parallel;
}

/// The measured voltage of one cell with the sensor's error taken out.
VectorXd true_voltage(const World& world, const LogFacts& facts) {
  if (facts.voltage_v.size() == 0 || facts.sensor_cells == 0.0) return facts.voltage_v;
  return ((facts.voltage_v.array() - world.voltage.offset / facts.sensor_cells) / (1.0 + world.voltage.gain)).matrix();
}

struct Branch {
  double v = 0.0;
  void step(double dt, double tau, double r_begin, double r_end, double begin, double end) {
    const double a = std::exp(-dt / tau), x = tau / dt * (1.0 - a);
    v = a * v + (x - a) * r_begin * begin + (1.0 - x) * r_end * end;
  }
};

}  // namespace

VectorXd shifted(const VectorXd& time_s, const VectorXd& values, double shift_s) {
  VectorXd out(values.size());
  const Index n = values.size();
  Index at = 0;
  for (Index row = 0; row < n; ++row) {
    const double t = time_s(row) + shift_s;
    while (at + 2 < n && time_s(at + 1) <= t) ++at;
    while (at > 0 && time_s(at) > t) --at;
    const double fraction = std::clamp((t - time_s(at)) / (time_s(at + 1) - time_s(at)), 0.0, 1.0);
    out(row) = values(at) + fraction * (values(at + 1) - values(at));
  }
  return out;
}

VectorXd reading(const SensorError& error, const VectorXd& time_s, const VectorXd& values) {
  VectorXd out = error.delay_s != 0.0 ? shifted(time_s, values, -error.delay_s) : values;
  return (out.array() * (1.0 + error.gain) + error.offset).matrix();
}

VectorXd lagged(const VectorXd& time_s, const VectorXd& values, double tau_s) {
  VectorXd out = values;
  for (Index row = 1; row < out.size(); ++row) {
    const double dt = time_s(row) - time_s(row - 1), a = std::exp(-dt / tau_s), x = tau_s / dt * (1.0 - a);
    out(row) = a * out(row - 1) + (x - a) * values(row - 1) + (1.0 - x) * values(row);
  }
  return out;
}

BatteryResponse battery_response(const World& world, const Recording& log, const LogFacts& facts) {
  const CellParameters& cell = world.car.cell;
  const CellEffects& effects = cell.effects;
  const CellTables tables(cell);
  const Index n = log.rows();
  BatteryResponse out;
  out.current_a = true_current(world, log, facts.current_a);
  for (VectorXd* v : {&out.voltage_v, &out.soc, &out.ocv_slope_v, &out.drop_v, &out.r0_ohm, &out.temperature_c}) v->resize(n);
  const double floor = world.car.battery.lookup_current_floor_a;
  const double heat_capacity = cell.mass_kg * cell.heat_capacity_j_per_kg_k;
  const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2;
  double soc = facts.initial_soc + world.initial_soc_change, temperature = facts.initial_temperature_c, lookup = 0.0;
  Branch one, two;
  CellEffectState state;
  CircuitParameters before{};
  const VectorXd measured = true_voltage(world, facts);
  double heat_before = 0.0;  // power [W] that heated at the row before, by the measured voltage
  for (Index row = 0; row < n; ++row) {
    const double end = out.current_a(row);
    const double before_a = row == 0 ? end : out.current_a(row - 1);
    const double begin = facts.hold == CurrentHold::kNext ? end : before_a;
    const double last = facts.hold == CurrentHold::kPrevious ? before_a : end;
    const double dt = row == 0 ? 0.0 : log.time_s(row) - log.time_s(row - 1);
    if (row > 0) soc -= 0.5 * (begin + last) * dt / (3600.0 * cell.capacity_ah);
    if (std::abs(end) > floor) lookup = std::abs(end);
    const double at_c = facts.temperature_c.size() > 0 ? facts.temperature_c(row) : temperature;
    const CircuitParameters p = tables.circuit(soc, at_c, lookup);
    if (row > 0) {
      one.step(dt, 0.5 * (before.tau1_s + p.tau1_s), before.r1_ohm, p.r1_ohm, begin, last);
      two.step(dt, 0.5 * (before.tau2_s + p.tau2_s), before.r2_ohm, p.r2_ohm, begin, last);
      if (has_dynamics(effects)) advance(effects, state, begin, last, cell.capacity_ah, dt);
      const double square = (begin * begin + begin * last + last * last) / 3.0, mean = 0.5 * (begin + last);
      double heat = square * p.r0_ohm + one.v * one.v / p.r1_ohm + two.v * two.v / p.r2_ohm + drop_of(effects, state) * mean;
      if (measured.size() > 0) {
        // Where the voltage is known so is the heat, whatever the resistances are.
        const double heat_now = last * (tables.ocv(soc).voltage_v - measured(row));
        heat = 0.5 * (heat_before + heat_now);
        heat_before = heat_now;
      }
      heat += reversible_heat(effects, mean, temperature);
      const bool stopped = facts.stopped[static_cast<std::size_t>(row)];
      const double w = cooling * (stopped ? 1.0 + world.cooling_at_stop_change : 1.0);
      const double ambient =
          (facts.ambient_above_model_k.size() > 0 ? facts.ambient_above_model_k(row) : 0.0) +
          world.car.environment.ambient_c;
      temperature = w > 0.0 ? ambient + heat / w + (temperature - ambient - heat / w) * std::exp(-dt * w / heat_capacity)
                            : temperature + heat * dt / heat_capacity;
    }
    before = p;
    const OcvPoint ocv = tables.ocv(soc);
    out.soc(row) = soc;
    out.ocv_slope_v(row) = ocv.slope_v;
    out.r0_ohm(row) = p.r0_ohm;
    out.drop_v(row) = p.r0_ohm * end + one.v + two.v + drop_of(effects, state);
    out.voltage_v(row) = ocv.voltage_v - out.drop_v(row);
    out.temperature_c(row) = temperature;
  }
  return out;
}

}  // namespace voltlap::plant
