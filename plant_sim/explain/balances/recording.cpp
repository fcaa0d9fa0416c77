// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/errors.hpp"
#include "explain/balances/held_cells.hpp"
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kLeastRows = 20;
constexpr double kTurns = 2.0;   // how long a value holds
constexpr double kSeldom = 1.5;  // turns of the current from which a channel is read more seldom
constexpr double kBurst = 2.0;   // mean over median interval from which samples come in bursts

VectorXd values_of(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

/// Any voltage of the battery.
const Channel* battery_voltage(const DriveLog& log) {
  for (const char* role : {"voltage", "pack_voltage", "cell_voltage_1", "bus_voltage"}) {
    if (const Channel* found = log.find(role)) return found;
  }
  return nullptr;
}

/// Times of the current, each once; a clock that repeats a time says nothing new.
std::vector<double> times_of(const Channel& current) {
  std::vector<double> out;
  for (const double t : current.time_s) {
    if (out.empty() || t > out.back()) out.push_back(t);
  }
  return out;
}

double usual_interval(const std::vector<double>& time_s) {
  std::vector<double> steps;
  for (std::size_t row = 1; row < time_s.size(); ++row) steps.push_back(time_s[row] - time_s[row - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

struct Held {
  VectorXd value, age_s;
};

/// The latest sample at each row: nothing where that one has no value or is older than `longest_s`.
Held latest(const Channel& channel, const std::vector<double>& time_s, double longest_s) {
  const auto rows = static_cast<Index>(time_s.size());
  Held out{VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN()), VectorXd::Zero(rows)};
  std::size_t next = 0;
  for (Index row = 0; row < rows; ++row) {
    const double t = time_s[static_cast<std::size_t>(row)];
    while (next < channel.size() && channel.time_s[next] <= t) ++next;
    if (next == 0 || t - channel.time_s[next - 1] > longest_s) continue;
    out.value(row) = channel.value[next - 1];
    out.age_s(row) = t - channel.time_s[next - 1];
  }
  return out;
}

/// How often a channel comes: the mean where it comes in bursts.
double usual_turn(const std::vector<double>& time_s) {
  const double mean = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const double median = usual_interval(time_s);
  return mean > kBurst * median ? mean : median;
}

/// One line a defect; a defect that many cells or thermistors have is one line too.
void put_defects(const std::vector<LogDefect>& defects, Recording& log) {
  std::map<std::pair<std::string, std::string>, std::vector<const LogDefect*>> alike;
  for (const LogDefect& defect : defects) {
    const std::size_t end = defect.channel.find_last_of('_');
    const bool numbered = defect.channel.starts_with("cell_voltage_") || defect.channel.starts_with("temperature_");
    alike[{defect.kind, numbered ? defect.channel.substr(0, end) : defect.channel}].push_back(&defect);
  }
  for (const auto& [key, same] : alike) {
    if (same.size() < 3) {
      for (const LogDefect* defect : same) log.repairs.push_back(defect->text);
      continue;
    }
    double count = 0.0, first = same.front()->first_s;
    for (const LogDefect* defect : same) {
      count += static_cast<double>(defect->count);
      first = std::min(first, defect->first_s);
    }
    log.repairs.push_back(fmt::format("{} {}: {:.0f} x {}, first at {:.3f} s", same.size(),
                                      key.second == "temperature" ? "thermistors" : "cells", count, key.first,
                                      first));
  }
}

}  // namespace

const VectorXd* Recording::find(const std::string& role) const {
  const auto found = signals.find(role);
  return found == signals.end() ? nullptr : &found->second;
}

std::vector<std::string> Recording::numbered(const std::string& stem) const {
  std::vector<std::pair<int, std::string>> found;
  for (const auto& [role, values] : signals) {
    if (role.starts_with(stem)) found.emplace_back(std::stoi(role.substr(stem.size())), role);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> out;
  for (auto& [number, role] : found) out.push_back(role);
  return out;
}

Recording read_recording(const DataFolder& data, const std::string& path, const std::string& map_name) {
  std::optional<RoleMap> map;
  if (!map_name.empty()) map = load_role_map(data.find("maps", map_name, "--map"));
  const DriveLog read = read_drive_log(path, map ? &*map : nullptr, data);
  const Channel *current = read.find("current"), *voltage = battery_voltage(read);
  if (current == nullptr || voltage == nullptr) {
    throw InputError(path, current == nullptr ? "no current" : "no voltage of the battery",
                     "a role current, and one of voltage, pack_voltage and cell_voltage_<n>",
                     "Add the role to the map (--map)");
  }
  if (read.sign_contradicted) {
    throw InputError(path, "a voltage that rises when the current rises",
                     "the sign of discharge as the map declares it",
                     "Change the sign in the map, or set discharge = \"auto\"");
  }
  const std::vector<double> time = times_of(*current);
  if (static_cast<Index>(time.size()) < kLeastRows) {
    throw InputError(path, fmt::format("{} usable rows of the current", time.size()),
                     fmt::format("at least {}", kLeastRows), "Check the columns in the map");
  }
  Recording log;
  log.path = path;
  log.repairs = read.notes;
  log.temperatures_of_core = read.temperatures_of_core;
  log.published_is_no_measurement = read.published_is_no_measurement;
  put_defects(read.defects, log);
  for (const MaskedStretch& m : read.masked) log.masked.push_back({m.channel, m.start_s, m.end_s, m.reason});
  log.time_s = values_of(time);
  const double turn = usual_turn(time);
  for (const auto& [role, channel] : read.channels) {
    if (role == "time" || channel.size() < 2) continue;
    const double own = usual_turn(channel.time_s);
    Held held = latest(channel, time, kTurns * std::max(own, turn));
    log.signals[role] = std::move(held.value);
    log.read_s[role] = log.time_s - held.age_s;
    if (own > kSeldom * turn) log.age_s[role] = std::move(held.age_s);
  }
  settle_held_cells(log);
  return log;
}

}  // namespace voltlap::plant
