// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/battery_response.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_effects.hpp"
#include "car/battery/cell_tables.hpp"

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
    out(row) = (out(row) - world.current.offset) / (1.0 + world.current.gain);
  }
  return out / world.car.battery.cells_in_parallel;
}

/// The measured voltage of one cell with the sensor's error taken out.
VectorXd true_voltage(const World& world, const LogFacts& facts) {
  if (facts.voltage_v.size() == 0 || facts.sensor_cells == 0.0) return facts.voltage_v;
  return ((facts.voltage_v.array() - world.voltage.offset / facts.sensor_cells) / (1.0 + world.voltage.gain)).matrix();
}

/// The measured temperature of the cell with the thermistors' error taken out: a first-order lag reads what is true less
/// the lag times how fast the reading rises.
VectorXd true_temperature(const World& world, const Recording& log, const LogFacts& facts) {
  if (facts.temperature_c.size() == 0) return {};
  VectorXd out = (facts.temperature_c.array() - world.thermistor_offset_k).matrix();
  if (world.thermistor_delay_s != 0.0) out += world.thermistor_delay_s * rate_of_change(log.time_s, facts.temperature_c);
  return out;
}

/// SOC at which a log begins: what its first rest says to who knows this world, or as it is stated.
double first_soc(const World& world, const LogFacts& facts, double temperature_c, const CellTables& tables) {
  if (!facts.starts_at_rest) return facts.initial_soc;
  const double sensor = facts.sensor_cells > 0.0 ? facts.sensor_cells : 1.0;
  const SensorError read = facts.sensor_cells > 0.0 ? world.voltage : SensorError{};
  const double volts = (facts.rest_voltage_v - read.offset / sensor) / (1.0 + read.gain);
  const double current = (facts.rest_current_a - world.current.offset) / (1.0 + world.current.gain) /
                         world.car.battery.cells_in_parallel;
  return tables.soc_of_ocv(volts + facts.rest_ohm * current, temperature_c);
}

struct Branch {
  double v = 0.0;
  void step(double dt, double tau, double r_begin, double r_end, double begin, double end) {
    const double a = std::exp(-dt / tau), x = tau / dt * (1.0 - a);
    v = a * v + (x - a) * r_begin * begin + (1.0 - x) * r_end * end;
  }
};

/// The cell at a row, and what goes on from there.
struct CellState {
  double current_a = 0.0, soc = 0.0;
  double temperature_c = 0.0, surface_c = 0.0;  ///< by its own heat
  double at_c = 0.0;           ///< at which the tables are read
  double lookup_a = 0.0;       ///< current at which the tables are read
  Branch one, two;
  CellEffectState effects;
  CircuitParameters circuit{};
  double heat_w = 0.0;         ///< by the measured voltage
};

/// One row after the other.
class Cell {
 public:
  Cell(const World& world, const Recording& log, const LogFacts& facts)
      : world_(world), log_(log), facts_(facts), tables_(world.car.cell), measured_(true_voltage(world, facts)),
        temperature_c_(true_temperature(world, log, facts)) {
    if (facts.sensor_cells > 0.0) {
      contact_ohm_ = world.pack_resistance_ohm * world.car.battery.cells_in_parallel / facts.sensor_cells;
    }
  }

  [[nodiscard]] CellState begin() const {
    CellState out;
    out.surface_c = temperature_c_.size() > 0 ? temperature_c_(0) : facts_.initial_temperature_c;
    out.temperature_c = out.at_c = out.surface_c;
    out.soc = first_soc(world_, facts_, out.temperature_c, tables_) + world_.initial_soc_change;
    return out;
  }

  [[nodiscard]] CellState at(const CellState& from, Index row, double current_a) const {
    CellState out = from;
    out.current_a = current_a;
    const CellParameters& cell = world_.car.cell;
    const double before_a = row == 0 ? current_a : from.current_a;
    const double begin = facts_.hold == CurrentHold::kNext ? current_a : before_a;
    const double end = facts_.hold == CurrentHold::kPrevious ? before_a : current_a;
    const double dt = row == 0 ? 0.0 : log_.time_s(row) - log_.time_s(row - 1);
    if (row > 0) out.soc -= 0.5 * (begin + end) * dt / (3600.0 * cell.capacity_ah);
    if (std::abs(current_a) > world_.car.battery.lookup_current_floor_a) out.lookup_a = std::abs(current_a);
    out.at_c = from.temperature_c;
    if (temperature_c_.size() > 0) {
      out.at_c = temperature_c_(row) + (facts_.above_surface_k.size() > 0 ? facts_.above_surface_k(row) : 0.0);
    }
    out.circuit = tables_.circuit(out.soc, out.at_c, out.lookup_a);
    if (row > 0) {
      const CircuitParameters &before = from.circuit, &p = out.circuit;
      out.one.step(dt, 0.5 * (before.tau1_s + p.tau1_s), before.r1_ohm, p.r1_ohm, begin, end);
      out.two.step(dt, 0.5 * (before.tau2_s + p.tau2_s), before.r2_ohm, p.r2_ohm, begin, end);
      if (has_dynamics(cell.effects)) advance(cell.effects, out.effects, begin, end, cell.capacity_ah, dt);
      warm(out, row, dt, begin, end);
    }
    return out;
  }

  /// The current with which the voltage at its sensor is what was measured, never less than `least_a` of the same sign.
  [[nodiscard]] CellState at_measured_voltage(const CellState& from, Index row, double least_a) const {
    constexpr int kRounds = 6;
    constexpr double kEnough = 1e-3, kMost = 5.0;  // A; of the limit
    CellState out = at(from, row, std::abs(from.current_a) > std::abs(least_a) && from.current_a * least_a > 0.0
                                      ? from.current_a : least_a);
    const double sign = least_a < 0.0 ? -1.0 : 1.0, least = std::abs(least_a);
    for (int round = 0; round < kRounds; ++round) {
      const double voltage = ocv_v(out) - drop_v(out) - contact_ohm_ * out.current_a;
      const double too_high = voltage - measured_(row);
      const double next = sign * (out.current_a + too_high / (out.circuit.r0_ohm + contact_ohm_));
      const double bounded = sign * std::clamp(next, least, kMost * least);
      const bool done = std::abs(bounded - out.current_a) < kEnough;
      out = at(from, row, bounded);
      if (done) break;
    }
    return out;
  }

  [[nodiscard]] double drop_v(const CellState& s) const {
    return s.circuit.r0_ohm * s.current_a + s.one.v + s.two.v + drop_of(world_.car.cell.effects, s.effects);
  }
  [[nodiscard]] double ocv_v(const CellState& s) const { return tables_.ocv_v(s.soc, s.at_c); }
  [[nodiscard]] const CellTables& tables() const { return tables_; }

 private:
  void warm(CellState& s, Index row, double dt, double begin, double end) const {
    const CellParameters& cell = world_.car.cell;
    const double square = (begin * begin + begin * end + end * end) / 3.0, mean = 0.5 * (begin + end);
    double heat = square * s.circuit.r0_ohm + s.one.v * s.one.v / s.circuit.r1_ohm +
                  s.two.v * s.two.v / s.circuit.r2_ohm + drop_of(cell.effects, s.effects) * mean;
    if (measured_.size() > 0) {
      // Where the voltage is known so is the heat, whatever the resistances are.
      const double now = end * (ocv_v(s) - measured_(row));
      heat = 0.5 * (s.heat_w + now);
      s.heat_w = now;
    }
    heat += reversible_heat(cell.effects, mean, s.temperature_c);
    const bool stopped = facts_.stopped[static_cast<std::size_t>(row)];
    const double w = cell.convection_w_per_m2_k * cell.surface_area_m2 *
                     (stopped ? 1.0 + world_.cooling_at_stop_change : 1.0);
    const double capacity = cell.mass_kg * cell.heat_capacity_j_per_kg_k;
    const double ambient = (facts_.ambient_above_model_k.size() > 0 ? facts_.ambient_above_model_k(row) : 0.0) +
                           world_.car.environment.ambient_c;
    const double rise = heat * dt / capacity, fades = std::exp(-dt * w / capacity), t = s.temperature_c;
    s.temperature_c = w > 0.0 ? ambient + heat / w + (t - ambient - heat / w) * fades : t + rise;
    s.surface_c = surface_after(s.surface_c, t, s.temperature_c, cell.surface_lag_s, dt);
  }

  const World& world_;
  const Recording& log_;
  const LogFacts& facts_;
  CellTables tables_;
  VectorXd measured_, temperature_c_;
  double contact_ohm_ = 0.0;
};

}  // namespace

double soc_per_millivolt(const BatteryResponse& battery) {
  constexpr double kFlattest = 0.02;  // V; a flatter curve than that of any cell with a plateau tells nothing
  return 1e-3 / std::max(kFlattest, battery.ocv_slope_v(0));
}

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

VectorXd rate_of_change(const VectorXd& time_s, const VectorXd& values) {
  const Index last = values.size() - 1;
  VectorXd out = VectorXd::Zero(values.size());
  for (Index row = 0; last > 0 && row <= last; ++row) {
    const Index a = std::max<Index>(0, row - 1), b = std::min(last, row + 1);
    out(row) = (values(b) - values(a)) / (time_s(b) - time_s(a));
  }
  return out;
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
  const Index n = log.rows();
  BatteryResponse out;
  out.current_a = true_current(world, log, facts.current_a);
  for (VectorXd* v : {&out.voltage_v, &out.soc, &out.ocv_slope_v, &out.drop_v, &out.r0_ohm, &out.temperature_c,
                      &out.surface_c}) {
    v->resize(n);
  }
  const bool ends = world.current_limit_a > 0.0 && !facts.at_limit.empty() && facts.voltage_v.size() > 0;
  const double limit = world.current_limit_a / world.car.battery.cells_in_parallel;
  const Cell cell(world, log, facts);
  CellState state = cell.begin();
  for (Index row = 0; row < n; ++row) {
    const bool at_limit = ends && facts.at_limit[static_cast<std::size_t>(row)];
    state = at_limit ? cell.at_measured_voltage(state, row, std::copysign(limit, out.current_a(row)))
                     : cell.at(state, row, out.current_a(row));
    out.current_a(row) = state.current_a;
    const OcvPoint ocv = cell.tables().ocv(state.soc);
    out.soc(row) = state.soc;
    out.ocv_slope_v(row) = ocv.slope_v;
    out.r0_ohm(row) = state.circuit.r0_ohm;
    out.drop_v(row) = cell.drop_v(state);
    out.voltage_v(row) = cell.ocv_v(state) - out.drop_v(row);
    out.temperature_c(row) = state.temperature_c;
    out.surface_c(row) = state.surface_c;
  }
  return out;
}

}  // namespace voltlap::plant
