// SPDX-License-Identifier: Apache-2.0
#include "explain/model/observed.hpp"

#include <algorithm>
#include <cmath>

#include "explain/balances/car_balances.hpp"
#include "explain/balances/car_motion.hpp"
#include "explain/balances/recorded_motor.hpp"
#include "explain/gate/integrity.hpp"
#include "explain/gate/rail.hpp"
#include "explain/model/beginning.hpp"
#include "explain/model/between_rows.hpp"
#include "explain/model/lost_rows.hpp"
#include "explain/model/settled_temperature.hpp"
#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

constexpr double kBin_s = 0.1, kHeatBin_s = 1.0;  // what is faster is averaged
constexpr double kScan = 1.05;                    // bins are at least a whole turn of the slowest sensor
constexpr double kSettle_s = 0.5;                 // after the bus has come up
constexpr double kBlock_s = 60.0;
constexpr Index kLeastBlocks = 6, kMostBlocks = 60;
constexpr double kCharged = 0.45;  // of the squares in the first minutes: no cause looks so
constexpr double kMostBins = 40000.0;  // a test of a day takes no longer than an endurance
constexpr double kGap = 5.0;           // mean intervals between rows from which nothing was recorded between them

double bin_for(const plant::Recording& log, const std::vector<std::string>& roles, double least_s) {
  double bin = least_s;
  for (const std::string& role : roles) {
    // A cell that a table holds comes a row early or late.
    const bool held = log.cells_at_rows && log.age_s.contains(role);
    const double turn_s = usual_interval_s(log, role) + (held ? usual_interval_s(log, "current") : 0.0);
    bin = std::max(bin, kScan * turn_s);
  }
  return bin;
}

/// Roles whose mean a channel of the comparison is; empty: it is reckoned row by row.
std::vector<std::string> roles_of(const plant::Comparison& comparison, const std::string& channel) {
  const plant::Recording& log = comparison.log;
  if (channel == "temperature") return log.numbered("temperature_");
  if (channel == "voltage" && log.find("voltage") == nullptr) return log.numbered("cell_voltage_");
  if (channel == "voltage" || channel == "pack_voltage" || channel == "bus_voltage" || channel == "soc")
    return {channel};
  return {};
}

bool is_pack_beside_cells(const Observed& out, const std::string& channel) {
  return channel == "pack_voltage" && out.comparison.channels.front().name != channel;
}

VectorXd held_sum_of_cells(const plant::Recording& log) {
  VectorXd out = VectorXd::Zero(log.rows());
  for (const std::string& role : log.numbered("cell_voltage_")) out += *log.find(role);
  return out;
}

/// Rows' change of the current.
VectorXd steps_of(const VectorXd& current) {
  VectorXd out = VectorXd::Zero(current.size());
  for (Index row = 1; row < current.size(); ++row) out(row) = std::abs(current(row) - current(row - 1));
  return out;
}

double rms_of(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / std::max<double>(1.0, static_cast<double>(values.size())));
}

VectorXd over_its_rms(const VectorXd& values) {
  const double rms = rms_of(values);
  return rms > 0.0 ? VectorXd(values / rms) : values;
}

/// Leaves out bins that the mean beside them does not have.
void keep_known(ReadChannel& channel) {
  std::vector<bool> known;
  std::vector<double> left;
  for (const double v : channel.residual) {
    known.push_back(std::isfinite(v));
    if (known.back()) left.push_back(v);
  }
  if (left.size() == known.size()) return;
  channel.reader.keep(known);
  channel.residual = Eigen::Map<const VectorXd>(left.data(), static_cast<Index>(left.size()));
}

/// Time at which the bus has come up to the pack; the first row where no bus is recorded, or no pack.
double closed_from_s(const plant::Recording& log) {
  constexpr double kUp = 0.99;
  const VectorXd *bus = log.find("bus_voltage"), *pack = log.find("pack_voltage");
  if (bus == nullptr || pack == nullptr) return log.time_s(0);
  bool was_down = false;  // where the first that is known is up, nothing settles, or it is masked already
  for (Index row = 0; row < log.rows(); ++row) {
    if ((*bus)(row) >= kUp * (*pack)(row)) return log.time_s(row) + (was_down ? kSettle_s : 0.0);
    was_down = was_down || std::isfinite((*bus)(row) + (*pack)(row));
  }
  return log.time_s(0);
}

/// Before the contactors close neither the bus nor the power says anything.
void mask_open(plant::Comparison& comparison) {
  plant::Recording& log = comparison.log;
  const double from_s = closed_from_s(log);
  const auto mask = [&](VectorXd& values) {
    for (Index row = 0; row < log.rows() && log.time_s(row) < from_s; ++row) values(row) = std::nan("");
  };
  if (const auto bus = log.signals.find("bus_voltage"); bus != log.signals.end()) mask(bus->second);
  for (plant::BalanceChannel& channel : comparison.channels) {
    if (channel.name == "bus_voltage" || channel.name == "power") mask(channel.measured);
  }
}

/// What is recorded until each row: an hour between two rows is none of it.
VectorXd recorded_until(const VectorXd& time_s) {
  const double most = std::max(1.0, kGap * row_interval_s(time_s));
  VectorXd out = VectorXd::Zero(time_s.size());
  for (Index row = 1; row < time_s.size(); ++row) {
    out(row) = out(row - 1) + std::min(most, time_s(row) - time_s(row - 1));
  }
  return out;
}

/// Rows after the longest stretches of which nothing is known; between rows that are nearer the current is
/// straight, or as it was counted.
std::vector<Index> gaps_of(const VectorXd& time_s, const VectorXd& counted_a) {
  constexpr double kLong_s = 60.0;
  constexpr double kUncounted_s = 8.0;  // at 100 A some 4 mV of a pack of 27 Ah
  constexpr std::size_t kMost = 8;
  const double usual = kGap * row_interval_s(time_s);
  std::vector<Index> out;
  for (Index row = 1; row < time_s.size(); ++row) {
    const bool counted = counted_a.size() > 0 && std::isfinite(counted_a(row));
    if (time_s(row) - time_s(row - 1) > std::max(counted ? kLong_s : kUncounted_s, usual)) out.push_back(row);
  }
  const auto length = [&](Index row) { return time_s(row) - time_s(row - 1); };
  std::sort(out.begin(), out.end(), [&](Index a, Index b) { return length(a) > length(b); });
  out.resize(std::min(out.size(), kMost));
  std::sort(out.begin(), out.end());
  return out;
}

ReadChannel channel_of(const Observed& out, std::size_t c, double volts_bin_s) {
  const plant::BalanceChannel& from = out.comparison.channels[c];
  const plant::Recording &log = out.comparison.log, &read = out.read;
  const std::vector<std::string> roles = roles_of(out.comparison, from.name);
  const bool heat = from.balance == plant::Balance::kHeat;
  const double bin = bin_for(log, roles, heat ? kHeatBin_s : volts_bin_s);
  ReadChannel made{from.name,
                   from.unit,
                   from.balance,
                   practical_size(from.name, out),
                   roles.empty() ? Reader::of_rows(log, from.measured - out.base.channels[c], volts_bin_s)
                                 : Reader::of_roles(read, roles, bin),
                   {},
                   {}};
  if (roles.empty()) {
    made.residual = made.reader.values();
  } else if (is_pack_beside_cells(out, from.name)) {
    const double cells = static_cast<double>(log.numbered("cell_voltage_").size());
    const VectorXd beyond_cells = out.base.channels[c] - held_sum_of_cells(log);
    VectorXd known = beyond_cells.array().isFinite().select(beyond_cells, 0.0);
    made.residual = made.reader.values() - made.reader.of(cells * out.base.battery.voltage_v + known) -
                    cells * made.reader.matched(out.channels[0].reader, out.channels[0].residual);
  } else {
    made.residual = made.reader.values() - made.reader.of(out.base.channels[c]);
  }
  return made;
}

void put_members(Observed& out, double volts_bin_s) {
  const plant::Recording& log = out.comparison.log;
  for (std::size_t g = 0; g < out.comparison.groups.size(); ++g) {
    const plant::Group& group = out.comparison.groups[g];
    const bool heat = group.balance == plant::Balance::kHeat;
    const auto mean = std::find_if(out.channels.begin(), out.channels.end(), [&](const ReadChannel& c) {
      return c.name == (heat ? "temperature" : "voltage");
    });
    if (mean == out.channels.end()) continue;
    const VectorXd& predicted = out.base.channels[static_cast<std::size_t>(mean - out.channels.begin())];
    const double bin = bin_for(log, group.members, heat ? kHeatBin_s : volts_bin_s);
    for (std::size_t k = 0; k < group.members.size(); ++k) {
      ReadChannel one{group.members[k],
                      mean->unit,
                      group.balance,
                      mean->practical,
                      Reader::of_roles(out.read, {group.members[k]}, bin),
                      {},
                      {}};
      if (one.reader.size() == 0) continue;
      // Against the mean of the others.
      const auto alike = static_cast<double>(group.members.size());
      one.residual =
          (alike > 1.0 ? alike / (alike - 1.0) : 1.0) *
          (one.reader.values() - one.reader.of(predicted) - one.reader.matched(mean->reader, mean->residual));
      out.members.push_back({std::move(one), g, k});
    }
  }
}

/// RMS of what the steps of a channel's sensors hide, in practical sizes. Cells that are alike are rounded alike, and
/// their sum by as many steps as there are cells.
double hidden_by_steps(const Observed& log, const ReadChannel& channel) {
  const std::vector<std::string> cells = log.read.numbered("cell_voltage_");
  double error = 0.0;
  if (channel.name == "voltage" && !cells.empty()) {
    error = step_error(log.read, cells);
  } else if (log.read.find(channel.name) != nullptr) {
    error = step_error(log.read, {channel.name});
  }
  if (is_pack_beside_cells(log, channel.name))
    error = std::hypot(error, static_cast<double>(cells.size()) * step_error(log.read, cells));
  return error / channel.practical;
}

/// What tyres slip is known to a tenth of itself, so is what a motor that nobody read turns faster than the car; where
/// corners take of the tyres what no log tells, they slip once more that much or not at all.
double slip_doubt(const plant::World& model, const plant::Comparison& comparison, const VectorXd& power) {
  constexpr double kOfSlip = 0.1, kOfSlipInCorners = 1.0;  // chosen
  const plant::Recording& log = comparison.log;
  if (!log.derived.contains("motor_speed")) return 0.0;
  const VectorXd &motor = *log.find("motor_speed"), &speed = *log.find("speed");
  const double rolling = plant::kRpm * model.car.tyres.radius_m / model.car.powertrain.final_drive;
  double square = 0.0, count = 0.0;
  for (Index row = 0; row < power.size(); ++row) {
    const double slip = motor(row) * rolling / speed(row) - 1.0;
    if (!(speed(row) > plant::kMoving) || !std::isfinite(slip) || !std::isfinite(power(row))) continue;
    square += std::pow(power(row) * slip, 2);
    count += 1.0;
  }
  const double known = plant::knows_cornering(model, log) ? kOfSlip : kOfSlipInCorners;
  return known * std::sqrt(square / std::max(1.0, count));
}

}  // namespace

double practical_size(const std::string& channel, const Observed& log) {
  constexpr double kCell_v = 1e-3, kOfDrop = 0.005, kPack_v = 20e-3, kHeat_k = 0.1, kSoc = 0.005, kOfCar = 0.005;
  constexpr double kCoarse_s = 0.05, kCoarse = 3.0;
  const plant::Comparison& comparison = log.comparison;
  const VectorXd& drop_v = log.base.battery.drop_v;
  // Of what a current takes nobody knows a two-hundredth: the sensor's gain, a fifth of a kelvin.
  const double known_v = kOfDrop * rms_of(drop_v);
  const double volts = std::max(known_v, is_between_rows(comparison) ? kCoarse * kCell_v : kCell_v);
  if (channel == "voltage") return volts;
  if (channel == "temperature") {
    return std::max(kHeat_k, step_error_of_heat(log.read));
  }
  if (channel == "soc") return kSoc;
  const bool beside_cells = !comparison.log.numbered("cell_voltage_").empty() && !comparison.log.pack_is_nearer;
  if (channel.ends_with("voltage")) return beside_cells ? kPack_v : volts * log.model.car.battery.cells_in_series;
  const plant::BalanceChannel* found = comparison.find(channel);
  double square = 0.0, count = 0.0;
  for (const double v : found->measured) {
    if (!std::isfinite(v)) continue;
    square += v * v;
    count += 1.0;
  }
  // Between rows that are far apart a pedal is anywhere: the speed gained between them is known the worse. Power in
  // and power out are read in the same row.
  const VectorXd& time_s = comparison.log.time_s;
  const double row_s = (time_s(time_s.size() - 1) - time_s(0)) / static_cast<double>(time_s.size() - 1);
  const double known = row_s > kCoarse_s && channel != "power" ? kCoarse : 1.0;
  const double of_slip = channel == "power" ? slip_doubt(log.model, comparison, found->measured) : 0.0;
  return std::max(of_slip, known * kOfCar * std::sqrt(square / std::max(1.0, count)));
}

std::vector<VectorXd> Observed::effect_of(const plant::Prediction& changed) const {
  constexpr double kNothing = 1e-9;  // of a practical size
  std::vector<VectorXd> out(channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const VectorXd by_row = filled(changed.channels[c] - base.channels[c]);
    if (!(by_row.cwiseAbs().maxCoeff() > kNothing * channels[c].practical)) continue;
    out[c] = channels[c].reader.of(by_row);
  }
  return out;
}

std::vector<Index> Observed::blocks_of(const ReadChannel& channel) const {
  std::vector<Index> out;
  const VectorXd& time_s = comparison.log.time_s;
  Index row = 0;  // bins rise
  for (const double t : channel.reader.time_s()) {
    while (row + 1 < time_s.size() && time_s(row) < t) ++row;
    const double recorded = recorded_s(row);
    out.push_back(std::clamp<Index>(static_cast<Index>(recorded / block_s), 0, blocks - 1));
  }
  return out;
}

Observed observed(const plant::World& model, plant::Comparison comparison) {
  Observed out;
  out.model = model;
  out.comparison = std::move(comparison);
  out.comparison.facts.gaps = gaps_of(out.comparison.log.time_s, out.comparison.facts.counted_a);
  if (const auto rail = plant::rail_of(*out.comparison.log.find("current")))
    out.comparison.facts.at_limit = rail->at;
  mask_open(out.comparison);
  out.read = unstepped(out.comparison.log);
  leave_out_lost_rows(out.read, out.comparison.facts.current_a);
  out.thermistors_c = out.comparison.facts.temperature_c;
  if (out.thermistors_c.size() > 0) {
    out.fine_c = without_steps(out.comparison.log);
    for (const plant::BalanceChannel& channel : out.comparison.channels)
      if (channel.name == "temperature") out.read_c = channel.measured;
    if (!out.read_c.array().isFinite().any()) out.read_c = out.thermistors_c;  // each in a row of its own
  }
  settle_temperature(model, out, out.comparison.facts);
  settle_gaps(model, out.comparison);
  out.base = plant::predict(model, out.comparison);
  out.comparison.soc = out.base.battery.soc;
  const plant::Recording& log = out.comparison.log;
  out.recorded_s = recorded_until(log.time_s);
  const double seconds = out.recorded_s(log.rows() - 1);
  const double volts_bin_s = bin_for(log, roles_of(out.comparison, out.comparison.channels[0].name),
                                     std::max(kBin_s, seconds / kMostBins));
  const VectorXd steps = steps_of(out.base.battery.current_a);
  const auto finish = [&](ReadChannel& channel) {
    keep_known(channel);
    channel.rough = over_its_rms(channel.reader.of(steps));
    channel.stepped = hidden_by_steps(out, channel);
  };
  for (std::size_t c = 0; c < out.comparison.channels.size(); ++c)
    out.channels.push_back(channel_of(out, c, volts_bin_s));
  put_members(out, volts_bin_s);
  for (ReadChannel& channel : out.channels) finish(channel);
  for (Member& member : out.members) finish(member.channel);
  out.block_s =
      std::clamp(kBlock_s, seconds / static_cast<double>(kMostBlocks), seconds / static_cast<double>(kLeastBlocks));
  out.blocks = std::max<Index>(1, static_cast<Index>(std::floor(seconds / out.block_s)));
  put_between_rows(out);
  out.left_beside_charge = left_beside_charge(out);
  out.begins_charged = out.left_beside_charge < kCharged;
  return out;
}

}  // namespace voltlap::explain
