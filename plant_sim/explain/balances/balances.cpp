// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/balances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/battery/cell_tables.hpp"
#include "core/signal.hpp"
#include "explain/balances/car_balances.hpp"
#include "explain/balances/held_cells.hpp"
#include "explain/balances/counted_charge.hpp"
#include "explain/balances/start_under_load.hpp"
#include "explain/gate/integrity.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kStandstill = 0.3;    // m/s
constexpr double kStill = 3.0;         // s without current that count as a stop where no speed is recorded
constexpr double kThermal = 15.0;      // s on each side, over which temperatures are averaged
constexpr double kFirstRest = 120.0;   // s from the beginning, in which a rest tells the SOC
constexpr double kRestCurrent = 0.02;  // of the largest: a rest

VectorXd held(const VectorXd& values) {
  VectorXd out = values;
  double last = kNothing;
  for (Index row = 0; row < out.size() && !std::isfinite(last); ++row) last = out(row);
  for (Index row = 0; row < out.size(); ++row) {
    if (!std::isfinite(out(row))) out(row) = last;
    last = out(row);
  }
  return out;
}

VectorXd mean_of(const Recording& log, const std::vector<std::string>& roles) {
  VectorXd out = VectorXd::Zero(log.rows());
  for (const std::string& role : roles) out += *log.find(role);
  return out / static_cast<double>(roles.size());
}

double largest(const VectorXd& values) {
  double most = 0.0;
  for (const double v : values) {
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  }
  return most;
}

std::vector<bool> stopped_rows(const Recording& log) {
  const auto n = static_cast<std::size_t>(log.rows());
  std::vector<bool> out(n, false);
  if (const VectorXd* speed = log.find("speed")) {
    for (Index row = 0; row < log.rows(); ++row) out[static_cast<std::size_t>(row)] = (*speed)(row) < kStandstill;
    return out;
  }
  const VectorXd& current = *log.find("current");
  const double quiet = kRestCurrent * largest(current);
  double since = log.time_s(0);
  for (Index row = 0; row < log.rows(); ++row) {
    if (std::abs(current(row)) > quiet) since = log.time_s(row);
    out[static_cast<std::size_t>(row)] = log.time_s(row) - since > kStill;
  }
  return out;
}

/// What the sensor reads while nothing is drawn, and how far its noise and its steps go from there.
std::pair<double, double> rest_level(const VectorXd& current) {
  constexpr double kSigmas = 5.0, kSteps = 1.5, kLeast = 1e-3;
  const double most = largest(current);
  std::vector<double> quiet, steps;
  for (Index row = 1; row < current.size(); ++row) {
    if (!(std::abs(current(row)) <= kRestCurrent * most) || !(std::abs(current(row - 1)) <= kRestCurrent * most))
      continue;
    quiet.push_back(current(row));
    steps.push_back(std::abs(current(row) - current(row - 1)));
  }
  const double sigma = 1.4826 * median(steps) / std::sqrt(2.0);
  return {median(quiet), std::max({kSigmas * sigma, kSteps * step_of(current), kLeast * most})};
}

/// Averages the current where nothing is drawn for a while: there the noise of its sensor is all that changes, and
/// would come back as an error of the resistance that it is multiplied with.
void settle_rests(Comparison& out) {
  constexpr double kWindow = 5.0, kShortest = 0.35;  // s on each side; a stretch
  const VectorXd &time = out.log.time_s, &raw = *out.log.find("current");
  out.facts.current_a = raw;
  out.facts.counted_a = counted_current(out.log);
  out.facts.usual = usual_range(raw);
  out.facts.at_rest.assign(static_cast<std::size_t>(raw.size()), false);
  const auto [level, reach] = rest_level(raw);
  out.facts.rest_noise_a = reach;
  for (Index first = 0; first < raw.size();) {
    Index end = first;
    while (end < raw.size() && std::abs(raw(end) - level) <= reach) ++end;
    const Index n = end - first;
    if (n > 1 && time(end - 1) - time(first) > kShortest) {
      out.facts.current_a.segment(first, n) = smoothed(time.segment(first, n), raw.segment(first, n), kWindow);
      std::fill_n(out.facts.at_rest.begin() + first, n, true);
    }
    first = std::max(end, first + 1);
  }
}

/// Voltage of one cell as the model's battery sees it.
struct MainVoltage {
  VectorXd measured;
  std::string name;
  double cells = 1.0;
};

MainVoltage main_voltage(const World& model, const Recording& log) {
  const auto cells = log.numbered("cell_voltage_");
  if (const VectorXd* one = log.find("voltage")) return {*one, "voltage", 1.0};
  if (!cells.empty() && !log.pack_is_nearer) return {mean_of(log, cells), "voltage", 1.0};
  const char* role = log.find("pack_voltage") != nullptr ? "pack_voltage" : "bus_voltage";
  return {*log.find(role), role, static_cast<double>(model.car.battery.cells_in_series)};
}

Group group_of(const Recording& log, const std::string& stem, Balance balance) {
  Group group{stem, balance, log.numbered(stem), {}};
  if (group.members.size() < 2) return {};
  const VectorXd mean = mean_of(log, group.members);
  for (const std::string& role : group.members) group.deviation.push_back(*log.find(role) - mean);
  return group;
}

/// What the log says of the SOC that it begins with: the rest at the beginning if there is one, else what is
/// stated.
void settle_start(const World& model, const MainVoltage& voltage, bool soc_stated, Comparison& out) {
  const VectorXd& current = *out.log.find("current");
  const double quiet = kRestCurrent * largest(current);
  std::vector<double> volts;
  double current_sum = 0.0, count = 0.0, last_s = out.log.time_s(0);
  for (Index row = 0; row < out.log.rows() && out.log.time_s(row) <= out.log.time_s(0) + kFirstRest; ++row) {
    const bool rests = out.facts.at_rest[static_cast<std::size_t>(row)] || std::abs(current(row)) <= quiet;
    if (!rests) break;
    last_s = out.log.time_s(row);
    if (!std::isfinite(voltage.measured(row))) continue;
    volts.push_back(voltage.measured(row) / voltage.cells);
    current_sum += current(row);
    count += 1.0;
  }
  out.facts.initial_soc = soc_stated ? model.car.battery.initial_soc : 1.0;
  if (const VectorXd* soc = out.log.find("soc")) {
    const VectorXd known = held(*soc);
    if (std::isfinite(known(0))) out.facts.initial_soc = known(0);
  }
  out.facts.starts_at_rest = count > 0.0;
  out.facts.first_rest_s = last_s - out.log.time_s(0);
  if (count == 0.0) return;
  // The median: a log may begin while the contactors close.
  out.facts.rest_voltage_v = median(volts);
  out.facts.rest_current_a = current_sum / count;
  const CellParameters& cell = model.car.cell;
  out.facts.rest_ohm = CellTables(cell).circuit(0.5, cell.reference_temperature_c, cell.reference_current_a).r0_ohm;
}

/// Straight or held: whichever the voltage follows in the middle of its readings; a few readings at steps do not
/// decide.
void settle_hold(const World& model, Comparison& out) {
  constexpr double kClearly = 0.98;
  double best = 1e300;
  CurrentHold hold = CurrentHold::kLinear;
  for (const CurrentHold tried : {CurrentHold::kLinear, CurrentHold::kPrevious, CurrentHold::kNext}) {
    out.facts.hold = tried;
    const VectorXd left = out.channels[0].measured - predict(model, out).channels[0];
    double sum = 0.0;
    for (Index row = 1; row < left.size(); ++row) {
      const double step = std::abs(left(row) - left(row - 1));
      if (std::isfinite(step)) sum += step;
    }
    if (sum >= kClearly * best) continue;
    best = sum;
    hold = tried;
  }
  out.facts.hold = hold;
}

/// As a BMS reports it that knows the charge, or that counts the current it logs.
VectorXd reported_soc(const World& world, const Comparison& comparison, const LogFacts& facts,
                      const BatteryResponse& battery) {
  const double low = world.reported_soc_low + battery.soc(0) - world.reported_from_soc.value_or(battery.soc(0));
  if (!world.soc_is_counted) return (battery.soc.array() - low).matrix();
  const VectorXd &time = comparison.log.time_s, &current = facts.current_a;
  const double coulombs = 3600.0 * world.counted_ah * world.car.battery.cells_in_parallel;
  VectorXd out(time.size());
  double soc = battery.soc(0) - low;
  for (Index row = 0; row < time.size(); ++row) {
    const CurrentHold hold = facts.hold;
    const double begin = row == 0 || hold == CurrentHold::kNext ? current(row) : current(row - 1);
    const double end = row > 0 && hold == CurrentHold::kPrevious ? current(row - 1) : current(row);
    if (row > 0) soc -= 0.5 * (begin + end) * (time(row) - time(row - 1)) / coulombs;
    out(row) = soc;
  }
  return out;
}

/// Of the pack's terminals, from what was published. The bus beside it tells whether it is right.
/// What its sensor and its battery unit add is reckoned from the model's pack voltage: taken back from the readings
/// themselves, a delay would come out smeared over two rows.
VectorXd true_pack_voltage(const Recording& log, const VectorXd& added) {
  return *log.find("pack_voltage") - added.array().isFinite().select(added, 0.0);
}

/// What a battery unit adds to the pack's voltage before it publishes it: a resistance times the current, at once or
/// behind a filter, and what a filter of the voltage takes away.
VectorXd added_by_unit(const World& world, const VectorXd& time_s, const VectorXd& modelled_v,
                       const VectorXd& current) {
  const VectorXd ohmic = world.published_compensation_ohm * current;
  if (world.published_tau_s <= 0.0) return ohmic;
  const VectorXd filtered_v = world.published_filtered * modelled_v;
  return lagged(time_s, filtered_v + ohmic, world.published_tau_s) - filtered_v;
}

}  // namespace

const char* name_of(Balance balance) {
  constexpr const char* kNames[] = {"charge", "voltage", "heat", "force", "power"};
  return kNames[static_cast<std::size_t>(balance)];
}

const BalanceChannel* Comparison::find(const std::string& name) const {
  const auto found =
      std::find_if(channels.begin(), channels.end(), [&](const BalanceChannel& c) { return c.name == name; });
  return found == channels.end() ? nullptr : &*found;
}

Comparison comparison_of(const World& model, Recording recording, const ComparisonOptions& options) {
  Comparison out;
  out.log = std::move(recording);
  const Recording& log = out.log;
  const MainVoltage main = main_voltage(model, log);
  out.channels.push_back({main.name, Balance::kVoltage, "V", main.measured});
  const auto cells = log.numbered("cell_voltage_"), thermistors = log.numbered("temperature_");
  if (log.pack_is_nearer) {
    out.channels.push_back({"voltage", Balance::kVoltage, "V", mean_of(log, cells)});
  } else if (!cells.empty() && log.find("pack_voltage") != nullptr) {
    out.channels.push_back({"pack_voltage", Balance::kVoltage, "V", *log.find("pack_voltage")});
  }
  if (main.name != "bus_voltage" && log.find("bus_voltage") != nullptr) {
    out.channels.push_back({"bus_voltage", Balance::kVoltage, "V", *log.find("bus_voltage")});
  }
  out.facts.stopped = stopped_rows(log);
  settle_rests(out);
  // Heat by voltages of another time than the current's would be heat of loads that were not there.
  if (log.has_voltage_of_its_time()) out.facts.voltage_v = held(main.measured) / main.cells;
  out.facts.sensor_cells = main.name == "voltage" && !cells.empty() ? 0.0 : main.cells;
  const bool starts_at_rest = !out.facts.at_rest.empty() && out.facts.at_rest.front();
  if (options.judge_soc && starts_at_rest && log.find("soc") != nullptr) {
    out.channels.push_back({"soc", Balance::kCharge, "1", *log.find("soc")});
  }
  out.facts.initial_temperature_c = model.car.battery.initial_temperature_c;
  out.facts.temperature_known = options.temperature_stated || !thermistors.empty();
  if (!thermistors.empty()) {
    const VectorXd mean = mean_of(log, thermistors);
    out.channels.push_back({"temperature", Balance::kHeat, "K", mean});
    // A cell's temperature is slow; noise and steps of the thermistors would come back as errors of its resistance.
    out.facts.temperature_c = smoothed(log.time_s, held(mean), kThermal);
    out.facts.initial_temperature_c = out.facts.temperature_c(0);
  }
  if (const VectorXd* ambient = log.find("ambient")) {
    out.facts.ambient_above_model_k = (held(*ambient).array() - model.car.environment.ambient_c).matrix();
  }
  out.facts.air_step_k = options.air_step_k;
  const bool with_force = knows_cornering(model, log);
  for (BalanceChannel& channel : car_channels(model, log)) {
    const bool of_force = channel.name == "speed" || channel.name == "motor_speed";
    if (with_force || !of_force) out.channels.push_back(std::move(channel));
  }
  if (cells.size() > 1) out.groups.push_back(group_of(log, "cell_voltage_", Balance::kVoltage));
  if (thermistors.size() > 1) out.groups.push_back(group_of(log, "temperature_", Balance::kHeat));
  settle_start(model, main, options.soc_stated, out);
  if (options.hold) {
    out.facts.hold = *options.hold;
  } else {
    settle_hold(model, out);
  }
  settle_above_surface(model, out.log, out.facts);
  settle_start_under_load(model, main.cells, out);
  return out;
}

Prediction predict(const World& world, const Comparison& comparison) {
  return predict(world, comparison, comparison.facts);
}

namespace {

/// The channels, given the battery's response; those of the car from `unchanged` where it is given.
void put_channels(const World& world, const Comparison& comparison, const LogFacts& facts,
                  const Prediction* unchanged, Prediction& out) {
  const Recording& log = comparison.log;
  const double series = world.car.battery.cells_in_series;
  const VectorXd pack_current = out.battery.current_a * static_cast<double>(world.car.battery.cells_in_parallel);
  const auto cells = log.numbered("cell_voltage_");
  const bool is_mean =
      log.find("voltage") == nullptr;  // then the first channel is the cells' mean, reckoned already
  const VectorXd cells_v = cells.empty() || log.pack_is_nearer
                               ? VectorXd(series * out.battery.voltage_v)
                               : VectorXd((is_mean ? comparison.channels.front().measured : mean_of(log, cells)) *
                                          static_cast<double>(cells.size()));
  // As it is published, before its sensor's error.
  const VectorXd modelled_v = series * out.battery.voltage_v;
  const VectorXd terminals_v = cells_v - world.pack_resistance_ohm * pack_current,
                 unit_v = added_by_unit(world, log.time_s, modelled_v, pack_current), pack_v = terminals_v + unit_v;
  SensorError levels = world.voltage;
  levels.delay_s = 0.0;
  // Late is what the model says between the rows: cells that are read in turn are no curve of 10 ms.
  const VectorXd late =
      world.voltage.delay_s == 0.0 ? VectorXd::Zero(log.rows())
                                   : VectorXd(shifted(log.time_s, modelled_v, -world.voltage.delay_s) - modelled_v);
  const VectorXd sensed = reading(levels, log.time_s, pack_v) - pack_v + (1.0 + levels.gain) * late;
  const VectorXd old = older_cells(world, log.time_s, out.battery);
  for (const BalanceChannel& channel : comparison.channels) {
    const bool first = out.channels.empty();
    if (channel.name == "voltage" && !first) {
      const VectorXd within = true_pack_voltage(log, sensed + unit_v) + world.pack_resistance_ohm * pack_current;
      out.channels.push_back(within / series + old);
    } else if (first && channel.name == "voltage") {
      out.channels.push_back(cells.empty() ? reading(world.voltage, log.time_s, out.battery.voltage_v)
                                           : VectorXd(out.battery.voltage_v + old));
    } else if (first || channel.name == "pack_voltage") {
      out.channels.push_back(log.pack_is_nearer ? VectorXd(pack_v + sensed) : VectorXd(pack_v + sensed - series * old));
    } else if (channel.name == "bus_voltage") {
      const bool published = log.find("pack_voltage") != nullptr;
      const VectorXd before = published ? true_pack_voltage(log, sensed + unit_v) : terminals_v;
      out.channels.push_back(before - world.car.contactors.resistance_ohm * pack_current);
    } else if (channel.name == "soc") {
      out.channels.push_back(reported_soc(world, comparison, facts, out.battery));
    } else if (channel.name == "temperature") {
      VectorXd seen = (out.battery.surface_c.array() + world.thermistor_offset_k).matrix();
      // Measured, so that an error of the heat is not taken for one of the sensor.
      if (world.thermistor_delay_s != 0.0) seen -= world.thermistor_delay_s * thermistor_rate(log.time_s, facts);
      out.channels.push_back(std::move(seen));
    } else {
      out.channels.push_back(unchanged != nullptr ? unchanged->channels[out.channels.size()]
                                                  : car_prediction(channel.name, world, comparison, out.battery));
    }
  }
}

}  // namespace

Prediction predict(const World& world, const Comparison& comparison, const LogFacts& facts) {
  Prediction out;
  out.battery = battery_response(world, comparison.log, facts);
  put_channels(world, comparison, facts, nullptr, out);
  return out;
}

Prediction predict(const World& world, const Comparison& comparison, const Prediction& before, Acts acts) {
  return predict(world, comparison, comparison.facts, before, acts);
}

Prediction predict(const World& world, const Comparison& comparison, const LogFacts& facts, const Prediction& before,
                   Acts acts) {
  if (acts == Acts::kOnAll) return predict(world, comparison, facts);
  Prediction out;
  if (acts == Acts::kOnBattery) {
    out.battery = battery_response(world, comparison.log, facts);
    put_channels(world, comparison, facts, &before, out);
    return out;
  }
  out = before;
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
    const BalanceChannel& channel = comparison.channels[c];
    if (channel.balance != Balance::kPower && channel.balance != Balance::kForce) continue;
    out.channels[c] = car_prediction(channel.name, world, comparison, out.battery);
  }
  return out;
}

}  // namespace voltlap::plant
