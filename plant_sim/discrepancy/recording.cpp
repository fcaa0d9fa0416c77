// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/errors.hpp"
#include "logs/drive_log.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kLeastRows = 20;
constexpr double kHold = 3.0, kLeastHold = 2.5;  // intervals of the current, s: how long a slower channel holds
constexpr double kOwnHold = 2.0;                 // intervals of the channel itself

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
    throw InputError(path, "a voltage that rises when the current rises", "the sign of discharge as the map declares it",
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
  for (const LogDefect& defect : read.defects) log.repairs.push_back(defect.text);
  for (const MaskedStretch& m : read.masked) log.masked.push_back({m.channel, m.start_s, m.end_s, m.reason});
  log.time_s = values_of(time);
  const double longest = std::max(kHold * usual_interval(time), kLeastHold);
  for (const auto& [role, channel] : read.channels) {
    if (role == "time") continue;
    // A slow scan of many cells holds until its next turn.
    const double own = channel.time_s.size() > 1 ? kOwnHold * usual_interval(channel.time_s) : 0.0;
    log.signals[role] = values_of(held_at(channel, time, std::max(longest, own)));
  }
  return log;
}

}  // namespace voltlap::plant
