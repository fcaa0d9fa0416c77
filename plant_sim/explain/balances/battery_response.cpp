// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/battery_response.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell.hpp"
#include "explain/balances/counted_charge.hpp"

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

/// The mean current of one cell between the rows, from what its sensor counted.
VectorXd true_mean(const World& world, const Recording& log, const LogFacts& facts) {
  if (facts.counted_a.size() == 0) return {};
  VectorXd out = facts.counted_a;
  if (world.current.delay_s != 0.0) out = shifted(log.time_s, out, world.current.delay_s);
  return (out.array() - world.current.offset).matrix() /
         ((1.0 + world.current.gain) * world.car.battery.cells_in_parallel);
}

/// The measured voltage of one cell with the sensor's error taken out, and what a battery unit added: a filter of the
/// voltage to its first order.
VectorXd true_voltage(const World& world, const Recording& log, const LogFacts& facts) {
  if (facts.voltage_v.size() == 0 || facts.sensor_cells == 0.0) return facts.voltage_v;
  VectorXd out =
      ((facts.voltage_v.array() - world.voltage.offset / facts.sensor_cells) / (1.0 + world.voltage.gain)).matrix();
  if (world.published_compensation_ohm == 0.0) return out;
  const VectorXd ohmic = world.published_compensation_ohm / facts.sensor_cells * facts.current_a;
  if (world.published_tau_s <= 0.0) return out - ohmic;
  out -= lagged(log.time_s, ohmic, world.published_tau_s);
  return out - world.published_filtered * (lagged(log.time_s, out, world.published_tau_s) - out);
}

/// The measured temperature of the cell with the thermistors' error taken out: a first-order lag reads what is true
/// less the lag times how fast the reading rises.
VectorXd true_temperature(const World& world, const Recording& log, const LogFacts& facts) {
  if (facts.temperature_c.size() == 0) return {};
  VectorXd out = (facts.temperature_c.array() - world.thermistor_offset_k).matrix();
  if (world.thermistor_delay_s != 0.0) out += world.thermistor_delay_s * thermistor_rate(log.time_s, facts);
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

/// The cell at a row, and what goes on from there.
struct RowState : CellState {
  double current_a = 0.0;
  double at_c = 0.0;     ///< at which the tables are read
  double above_v = 0.0;  ///< the model's voltage above the measured one
};

/// One row after the other.
class LoggedCell {
 public:
  LoggedCell(const World& world, const Recording& log, const LogFacts& facts)
      : world_(world),
        log_(log),
        facts_(facts),
        cell_(world.car.cell),
        measured_(true_voltage(world, log, facts)),
        counted_a_(true_mean(world, log, facts)),
        temperature_c_(true_temperature(world, log, facts)) {
    if (facts.sensor_cells > 0.0) {
      contact_ohm_ = world.pack_resistance_ohm * world.car.battery.cells_in_parallel / facts.sensor_cells;
    }
  }

  [[nodiscard]] RowState begin() const {
    RowState out;
    // A sensor's noise is no current at which a resistance is asked for.
    const double noise_a = facts_.rest_noise_a / std::max(1, world_.car.battery.cells_in_parallel);
    out.lookup_floor_a = std::max(world_.car.battery.lookup_current_floor_a, noise_a);
    out.surface_c = temperature_c_.size() > 0 ? temperature_c_(0) : facts_.initial_temperature_c;
    out.at_c = out.surface_c;
    out.surface_c += world_.initial_warmth_k;
    out.temperature_c = out.surface_c;
    out.soc = first_soc(world_, facts_, out.temperature_c, cell_.tables()) + world_.initial_soc_change;
    out.effects.hysteresis = hysteresis_at_begin(out.soc);
    return out;
  }

  [[nodiscard]] RowState at(const RowState& from, Index row, double current_a) const {
    const auto gap = std::lower_bound(facts_.gaps.begin(), facts_.gaps.end(), row);
    if (gap != facts_.gaps.end() && *gap == row) return after_gap(from, row, current_a, gap - facts_.gaps.begin());
    RowState out = from;
    out.current_a = current_a;
    const double before_a = row == 0 ? current_a : from.current_a;
    const CellInterval interval = until(row, before_a, current_a);
    if (row > 0) out.soc -= soc_drawn(interval, world_.car.cell.capacity_ah);
    out.at_c = from.temperature_c;
    if (temperature_c_.size() > 0) {
      out.at_c = temperature_c_(row) + (facts_.above_surface_k.size() > 0 ? facts_.above_surface_k(row) : 0.0);
    }
    if (row == 0) {
      cell_.look_up(out, {current_a, out.soc, out.at_c});
      for (std::size_t b = 0; b < out.v.size(); ++b) out.v[b] = out.circuit.r_ohm[b] * facts_.charged_before_a;
      charge_branches(out, 0);
    } else {
      // A car's current fell through its floor between two rows: that was the last at which a resistance was asked
      // for. What a bench switches off falls through none.
      const double floor_a = world_.car.battery.lookup_current_floor_a;
      const bool fell = std::abs(before_a) > floor_a && std::abs(current_a) <= floor_a;
      if (floor_a > 0.0 && fell && facts_.hold == CurrentHold::kLinear) out.lookup_a = floor_a;
      const double heat_w = cell_.advance(out, interval, {current_a, out.soc, out.at_c});
      warm_row(out, row, heat_w, {interval, before_a, current_a});
    }
    return out;
  }

  /// The current with which the voltage at its sensor is what was measured, never less than `least_a` of the same
  /// sign.
  [[nodiscard]] RowState at_measured_voltage(const RowState& from, Index row, double least_a) const {
    constexpr int kRounds = 6;
    constexpr double kEnough = 1e-3, kMost = 5.0;  // A; of the limit
    RowState out = at(
        from, row,
        std::abs(from.current_a) > std::abs(least_a) && from.current_a * least_a > 0.0 ? from.current_a : least_a);
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

  [[nodiscard]] double drop_v(const RowState& s) const { return cell_.drop_v(s, s.current_a); }
  [[nodiscard]] double ocv_v(const RowState& s) const { return cell_.tables().ocv_v(s.soc, s.at_c); }
  [[nodiscard]] const CellTables& tables() const { return cell_.tables(); }

 private:
  /// A rest of unknown change of charge; how warm the cell is the thermistors say.
  [[nodiscard]] RowState after_gap(const RowState& from, Index row, double current_a, Index number) const {
    RowState out = from;
    out.current_a = current_a;
    const CellInterval rest{log_.time_s(row) - log_.time_s(row - 1), 0.0, 0.0};
    const auto gap = static_cast<std::size_t>(number);
    if (gap < facts_.soc_after_gap.size()) out.soc += facts_.soc_after_gap[gap];
    if (gap < world_.soc_after_gap.size()) out.soc += world_.soc_after_gap[gap];
    if (temperature_c_.size() > 0) {
      out.at_c = out.surface_c = temperature_c_(row);
      if (gap < world_.warmth_after_gap.size()) out.surface_c += world_.warmth_after_gap[gap];
      out.temperature_c = out.surface_c;
      cell_.advance(out, rest, {current_a, out.soc, out.at_c});
    } else {
      out.at_c = out.temperature_c;
      warm_row(out, row, cell_.advance(out, rest, {current_a, out.soc, out.at_c}), {rest, 0.0, 0.0});
    }
    charge_branches(out, gap + 1);
    return out;
  }

  /// As currents did that nobody recorded.
  void charge_branches(RowState& s, std::size_t start) const {
    if (start >= world_.charged_by_a.size()) return;
    for (std::size_t b = 0; b < s.v.size(); ++b) s.v[b] += s.circuit.r_ohm[b] * world_.charged_by_a[start][b];
  }

  /// The current until a row. Counted, its mean is known: it ends as it was read, and began as that asks for.
  [[nodiscard]] CellInterval until(Index row, double before_a, double current_a) const {
    const double seconds = row == 0 ? 0.0 : log_.time_s(row) - log_.time_s(row - 1);
    const bool at_limit = !facts_.at_limit.empty() && facts_.at_limit[static_cast<std::size_t>(row)];
    if (counted_a_.size() > 0 && std::isfinite(counted_a_(row)) && !at_limit)
      return {seconds, 2.0 * counted_a_(row) - current_a, current_a};
    return {seconds, facts_.hold == CurrentHold::kNext ? current_a : before_a,
            facts_.hold == CurrentHold::kPrevious ? before_a : current_a};
  }

  /// An interval between two rows, and what the current was at them.
  struct Step {
    CellInterval interval;
    double before_a, now_a;
  };

  /// Mean of current times a voltage that is straight between the rows.
  [[nodiscard]] double mean_power_w(const Step& step, double before_v, double now_v) const {
    const double a = step.before_a, b = step.now_a;
    if (facts_.hold == CurrentHold::kPrevious) return a * 0.5 * (before_v + now_v);
    if (facts_.hold == CurrentHold::kNext) return b * 0.5 * (before_v + now_v);
    return (2.0 * (a * before_v + b * now_v) + a * now_v + b * before_v) / 6.0;
  }

  /// A current that differs between two rows was switched somewhere between them, and I^2 is not that of a straight
  /// line; of one that changes slowly both are the same.
  [[nodiscard]] double switched_w(const RowState& s, Index row, const Step& step) const {
    constexpr double kKnown_s = 2.0;  // in longer ones it was anything
    if (step.interval.dt_s > kKnown_s || facts_.hold != CurrentHold::kLinear) return 0.0;
    const double cells = world_.car.battery.cells_in_parallel;
    const double beyond_a2 =
        facts_.beyond_straight_a2.size() > 0
            ? facts_.beyond_straight_a2(row) / (cells * cells)
            : switched_square(step.before_a, step.now_a, step.interval.mean_a(),
                              {facts_.usual.low_a / cells, facts_.usual.high_a / cells}) -
                  step.interval.mean_square_a2();
    return s.circuit.r0_ohm * beyond_a2;
  }

  void warm_row(RowState& s, Index row, double heat_w, const Step& step) const {
    const CellInterval& interval = step.interval;
    double heat = heat_w;
    if (measured_.size() > 0) {
      // Where the voltage is known so is the heat, whatever the resistances are: what the model's cell is above it
      // is turned into heat, too.
      const double above = ocv_v(s) - cell_.drop_v(s, step.now_a) - measured_(row);
      heat += mean_power_w(step, s.above_v, above);
      s.above_v = above;
    }
    heat += switched_w(s, row, step) + cell_.reversible_w(interval.mean_a(), s.temperature_c);
    CellThermal thermal = cell_.thermal();
    if (facts_.stopped[static_cast<std::size_t>(row)])
      thermal.cooling_w_per_k *= 1.0 + world_.cooling_at_stop_change;
    const double above = facts_.ambient_above_model_k.size() > 0 ? facts_.ambient_above_model_k(row) : 0.0;
    warm(s, thermal, heat, world_.car.environment.ambient_c + above, interval.dt_s);
  }

  const World& world_;
  const Recording& log_;
  const LogFacts& facts_;
  Cell cell_;
  VectorXd measured_, counted_a_, temperature_c_;
  double contact_ohm_ = 0.0;
};

/// Slope of the OCV as cells see it that are not all as full: the corners of its table, which they pass one after the
/// other, are no steps of a voltage.
double slope_about(const CellTables& tables, double soc) {
  constexpr double kApart = 0.01;
  return (tables.ocv(soc + kApart).voltage_v - tables.ocv(soc - kApart).voltage_v) / (2.0 * kApart);
}

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

VectorXd smoothed(const VectorXd& time_s, const VectorXd& values, double window_s) {
  VectorXd out(values.size());
  Index first = 0, last = -1;
  double sum = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    while (last + 1 < values.size() && time_s(last + 1) <= time_s(row) + window_s) sum += values(++last);
    while (time_s(first) < time_s(row) - window_s) sum -= values(first++);
    out(row) = sum / static_cast<double>(last - first + 1);
  }
  return out;
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

VectorXd thermistor_rate(const VectorXd& time_s, const LogFacts& facts) {
  constexpr double kWindow_s = 8.0;  // on each side, twice: noise of a reading is no rate
  const VectorXd& read = facts.thermistor_c.size() > 0 ? facts.thermistor_c : facts.temperature_c;
  return rate_of_change(time_s, smoothed(time_s, smoothed(time_s, read, kWindow_s), kWindow_s));
}

VectorXd lagged(const VectorXd& time_s, const VectorXd& values, double tau_s) {
  VectorXd out = values;
  for (Index row = 1; row < out.size(); ++row) {
    out(row) =
        first_order_step(time_s(row) - time_s(row - 1), tau_s).after(out(row - 1), values(row - 1), values(row));
  }
  return out;
}

BatteryResponse battery_response(const World& world, const Recording& log, const LogFacts& facts) {
  const Index n = log.rows();
  BatteryResponse out;
  out.current_a = true_current(world, log, facts.current_a);
  for (VectorXd* v :
       {&out.voltage_v, &out.soc, &out.ocv_slope_v, &out.drop_v, &out.r0_ohm, &out.temperature_c, &out.surface_c}) {
    v->resize(n);
  }
  const bool ends = world.current_limit_a > 0.0 && !facts.at_limit.empty() && facts.voltage_v.size() > 0;
  const double limit = world.current_limit_a / world.car.battery.cells_in_parallel;
  const LoggedCell cell(world, log, facts);
  RowState state = cell.begin();
  for (Index row = 0; row < n; ++row) {
    const bool at_limit = ends && facts.at_limit[static_cast<std::size_t>(row)];
    state = at_limit ? cell.at_measured_voltage(state, row, std::copysign(limit, out.current_a(row)))
                     : cell.at(state, row, out.current_a(row));
    out.current_a(row) = state.current_a;
    out.soc(row) = state.soc;
    out.ocv_slope_v(row) = slope_about(cell.tables(), state.soc);
    out.r0_ohm(row) = state.circuit.r0_ohm;
    out.drop_v(row) = cell.drop_v(state);
    out.voltage_v(row) = cell.ocv_v(state) - out.drop_v(row);
    out.temperature_c(row) = state.temperature_c;
    out.surface_c(row) = state.surface_c;
  }
  return out;
}

void settle_above_surface(const World& model, const Recording& log, LogFacts& facts) {
  if (model.car.cell.surface_lag_s <= 0.0 || facts.temperature_c.size() == 0) return;
  facts.above_surface_k.resize(0);
  // Once, so that a cause of the heat is told by the thermistors alone.
  const BatteryResponse battery = battery_response(model, log, facts);
  facts.above_surface_k = battery.temperature_c - battery.surface_c;
}

}  // namespace voltlap::plant
