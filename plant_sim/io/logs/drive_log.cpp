// SPDX-License-Identifier: Apache-2.0
#include "io/logs/drive_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/channel_builder.hpp"
#include "io/logs/current_sign.hpp"

namespace voltlap::plant {
namespace {

/// Roles by the recording that they come from; "" is the recording itself.
std::map<std::string, std::map<std::string, RoleSource>> by_file(const RoleMap& map) {
  std::map<std::string, std::map<std::string, RoleSource>> out;
  for (const auto& [role, source] : map.roles) {
    out[source.file.empty() ? "" : path_in_map(map, source.file)][role] = source;
  }
  return out;
}

/// Columns and frames do not mix within one file.
void check_kind(const RoleMap& map, const std::string& path, const std::map<std::string, RoleSource>& roles,
                bool is_can) {
  for (const auto& [role, source] : roles) {
    if (role == "time" || source.frame.has_value() == is_can) continue;
    throw InputError(
        fmt::format("{}: roles.{}", map.source, role), is_can ? "a column" : "a frame",
        fmt::format("{} for {}", is_can ? "frame, signal and dbc" : "column", path),
        is_can ? "That recording is a CAN log" : "That recording is a table, or in no known CAN format");
  }
}

/// A table has no frames: its samples are counted.
void count_samples(const Channel& channel, FrameAccount& account) {
  const auto used = static_cast<std::size_t>(
      std::count_if(channel.value.begin(), channel.value.end(), [](double value) { return std::isfinite(value); }));
  account.in_file += channel.size() + channel.left_out;
  account.stale += channel.left_out;
  account.used += used;
  account.corrupt += channel.size() - used;
}

void add_file(DriveLog& log, const RoleMap& map, const std::string& path,
              const std::map<std::string, RoleSource>& roles, bool main) {
  const bool is_can = is_can_recording(path);
  check_kind(map, path, roles, is_can);
  if (is_can) {
    std::map<std::string, RoleSource> frames = roles;
    frames.erase("time");
    if (!frames.empty()) add_can_channels(log, map, path, frames, main);
  } else {
    std::set<std::string> before;
    for (const auto& [role, channel] : log.channels) before.insert(role);
    add_table_channels(log, map, path, roles, main);
    for (const auto& [role, channel] : log.channels) {
      if (!before.contains(role)) count_samples(channel, log.frames);
    }
  }
}

struct Span {
  double begin = std::numeric_limits<double>::infinity(), end = -std::numeric_limits<double>::infinity();
};

Span span_of(const DriveLog& log, const std::map<std::string, RoleSource>& roles, bool within) {
  Span span;
  for (const auto& [role, channel] : log.channels) {
    const std::string stem = role.substr(0, role.find_last_of('_') + 1) + "<n>";
    const bool in = roles.contains(role) || roles.contains(stem);
    if (in != within || channel.time_s.empty()) continue;
    span.begin = std::min(span.begin, channel.time_s.front());
    span.end = std::max(span.end, channel.time_s.back());
  }
  return span;
}

/// A recording that was joined lies in the same stretch of time.
void check_overlap(const DriveLog& log, const std::string& path, const std::map<std::string, RoleSource>& roles) {
  const Span own = span_of(log, roles, false), other = span_of(log, roles, true);
  if (own.begin > own.end || other.begin > other.end) return;
  if (other.begin <= own.end && own.begin <= other.end) return;
  throw InputError(path, fmt::format("times from {:.3f} to {:.3f} s", other.begin, other.end),
                   fmt::format("an overlap with {}, {:.3f} to {:.3f} s", log.path, own.begin, own.end),
                   "Give shift_s, the seconds to be added to that file's clock, in the map");
}

constexpr double kClearSign = 0.2, kContradictedSign = 0.5;  // of sign_evidence

/// The battery's own voltages by rank; a bus is behind contactors, and an inverter's is its own affair.
const Channel* own_voltage_of(const DriveLog& log) {
  for (const char* role : {"voltage", "pack_voltage"}) {
    if (const Channel* channel = log.find(role)) return channel;
  }
  const auto cells = log.numbered("cell_voltage_");
  return cells.empty() ? nullptr : cells.front().second;
}

/// Evidence for the sign by the battery's own voltage, where that is clear, else by the bus. Some battery units publish
/// a voltage to which they add current times resistance: where the two contradict each other, the charge decides.
double battery_sign_evidence(const DriveLog& log, const Channel& current) {
  const Channel *own = own_voltage_of(log), *bus = log.find("bus_voltage");
  const auto whole_or_steps = [&](const Channel& voltage) {
    const double whole = whole_sign_evidence(current, voltage);
    return std::abs(whole) < kClearSign ? sign_evidence(current, voltage) : whole;
  };
  // A bus is charged and discharged behind its contactors: over the whole recording it says that.
  const double by_own = own == nullptr ? 0.0 : whole_or_steps(*own),
               by_bus = bus == nullptr ? 0.0 : sign_evidence(current, *bus);
  if (std::abs(by_own) < kClearSign) return std::abs(by_bus) < kClearSign && own != nullptr ? by_own : by_bus;
  const bool contradicted = std::abs(by_bus) >= kClearSign && by_own * by_bus < 0.0;
  return contradicted && charge_evidence(current, *own) * by_bus > 0.0 ? by_bus : by_own;
}

/// A published pack voltage that rises with the discharge current is no measurement of it.
void note_opposite_voltages(DriveLog& log, const Channel& current) {
  const Channel* bus = log.find("bus_voltage");
  const Channel* pack = log.find("pack_voltage");
  if (bus == nullptr || pack == nullptr) return;
  if (sign_evidence(current, *bus) > -kClearSign || sign_evidence(current, *pack) < kClearSign) return;
  log.published_is_no_measurement = true;
  log.notes.emplace_back(
      "pack_voltage rises with the discharge current while bus_voltage falls: what is published "
      "is not what is measured");
}

void settle_sign(DriveLog& log, const RoleMap& map) {
  const auto found = log.channels.find("current");
  const RoleSource* source = map.find("current");
  if (found == log.channels.end() || source == nullptr) return;
  log.declared = source->discharge;
  Channel& current = found->second;
  double evidence = battery_sign_evidence(log, current);
  if (log.declared == DischargeSign::kNegative) evidence = -evidence;
  log.sign_contradicted = log.declared != DischargeSign::kAuto && evidence > kContradictedSign;
  const bool turn =
      log.declared == DischargeSign::kNegative || (log.declared == DischargeSign::kAuto && evidence > 0.0);
  if (log.declared == DischargeSign::kAuto) {
    log.notes.push_back(
        fmt::format("current: discharge is {} in the recording{}", turn ? "negative" : "positive",
                    std::abs(evidence) < kClearSign ? ", by weak evidence; declare it in the map" : ""));
  }
  if (turn) {
    for (double& value : current.value) value = -value;
  }
  note_opposite_voltages(log, current);
}

std::map<long, double> block_means(const Channel& channel, double block_s) {
  VOLTLAP_DEMAND(channel.time_s.size() == channel.value.size() && block_s > 0.0);
  std::map<long, std::pair<double, double>> sums;
  for (std::size_t k = 0; k < channel.size(); ++k) {
    if (!std::isfinite(channel.value[k])) continue;
    auto& [sum, count] = sums[static_cast<long>(std::floor(channel.time_s[k] / block_s))];
    sum += channel.value[k];
    count += 1.0;
  }
  std::map<long, double> out;
  for (const auto& [block, entry] : sums) out[block] = entry.first / entry.second;
  return out;
}

/// No step counts more than the larger tenth of them.
void clip_to_usual(std::vector<double>& steps) {
  if (steps.empty()) return;
  std::vector<double> sizes;
  for (const double step : steps) sizes.push_back(std::abs(step));
  const double usual = quantile(std::move(sizes), 0.9);
  for (double& step : steps) step = std::clamp(step, -usual, usual);
}

}  // namespace

const Channel* DriveLog::find(const std::string& role) const {
  const auto at = channels.find(role);
  return at == channels.end() ? nullptr : &at->second;
}

std::vector<std::pair<int, const Channel*>> DriveLog::numbered(const std::string& stem) const {
  std::vector<std::pair<int, const Channel*>> out;
  for (const auto& [role, channel] : channels) {
    if (!role.starts_with(stem)) continue;
    int n = 0;
    const auto [end, error] = std::from_chars(role.data() + stem.size(), role.data() + role.size(), n);
    if (error == std::errc{} && end == role.data() + role.size()) out.emplace_back(n, &channel);
  }
  std::sort(out.begin(), out.end());
  return out;
}

DriveLog read_drive_log(const std::string& path, const RoleMap* given, const DataFolder& data) {
  RoleMap found;
  if (given == nullptr) found = role_map_for_drive(path, data);
  const RoleMap& map = given != nullptr ? *given : found;
  DriveLog log;
  log.path = path;
  log.map = map.source;
  log.temperatures_of_core = map.temperatures_of_core;
  const auto files = by_file(map);
  if (const auto own = files.find(""); own != files.end()) add_file(log, map, path, own->second, true);
  for (const auto& [file, roles] : files) {
    if (file.empty()) continue;
    add_file(log, map, file, roles, false);
    check_overlap(log, file, roles);
    log.notes.push_back(fmt::format("joined on time: {}", file));
  }
  if (log.channels.empty()) {
    throw InputError(path, "no usable value of any role", "the columns or frames of " + log.map,
                     "Check that map and recording belong together");
  }
  settle_sign(log, map);
  VOLTLAP_DEMAND(!log.map.empty() && log.path == path);
  return log;
}

std::vector<double> held_at(const Channel& channel, const std::vector<double>& time_s, double longest_s) {
  VOLTLAP_DEMAND(channel.time_s.size() == channel.value.size());
  VOLTLAP_DEMAND(longest_s >= 0.0);
  std::vector<double> out(time_s.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t next = 0;
  double value = std::numeric_limits<double>::quiet_NaN(), since = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    for (; next < channel.size() && channel.time_s[next] <= time_s[k]; ++next) {
      if (!std::isfinite(channel.value[next])) continue;
      value = channel.value[next];
      since = channel.time_s[next];
    }
    if (time_s[k] - since <= longest_s) out[k] = value;
  }
  return out;
}

double sign_evidence(const Channel& current, const Channel& voltage) {
  // Means over blocks longer than a delay on a bus; sizes are clipped, so that no contactor and no spike decides.
  // A step that is small beside the current is its noise.
  constexpr double kBlock = 1.0, kStep = 0.01;  // s; of the largest current
  const auto i = block_means(current, kBlock), u = block_means(voltage, kBlock);
  double largest = 0.0;
  for (const auto& [block, mean] : i) largest = std::max(largest, std::abs(mean));
  std::vector<double> di, du;
  for (auto at = i.begin(); at != i.end(); ++at) {
    const auto after = i.find(at->first + 1), u0 = u.find(at->first), u1 = u.find(at->first + 1);
    if (after == i.end() || u0 == u.end() || u1 == u.end()) continue;
    if (std::abs(after->second - at->second) < kStep * largest) continue;
    di.push_back(after->second - at->second);
    du.push_back(u1->second - u0->second);
  }
  VOLTLAP_DEMAND(di.size() == du.size());
  clip_to_usual(di);
  clip_to_usual(du);
  double with = 0.0, size = 0.0;
  for (std::size_t k = 0; k < di.size(); ++k) {
    with += di[k] * du[k];
    size += std::abs(di[k] * du[k]);
  }
  return size > 0.0 ? with / size : 0.0;
}

double charge_evidence(const Channel& current, const Channel& voltage) {
  constexpr double kBlock = 1.0, kQuiet = 0.05, kNet = 0.1, kMoved = 0.002;  // s; of the largest current; of all; of it
  constexpr std::size_t kFewest = 3;
  constexpr long kSettles = 8;  // blocks without a current, until a unit's filter and a cell's branch show little
  const auto i = block_means(current, kBlock), u = block_means(voltage, kBlock);
  if (i.empty()) return 0.0;
  double largest = 0.0, net = 0.0, all = 0.0;
  for (const auto& [block, mean] : i) {
    largest = std::max(largest, std::abs(mean));
    net += mean;
    all += std::abs(mean);
  }
  const long first = i.begin()->first, last = i.rbegin()->first, third = (last - first) / 3;
  std::vector<double> early, late;
  long quiet = 0;
  for (const auto& [block, mean] : i) {
    const auto volts = u.find(block);
    quiet = std::abs(mean) > kQuiet * largest ? 0 : quiet + 1;
    if (quiet <= kSettles || volts == u.end()) continue;
    if (block <= first + third) early.push_back(volts->second);
    if (block >= last - third) late.push_back(volts->second);
  }
  if (std::abs(net) < kNet * all) return 0.0;
  const double of_a_drive = net > 0.0 ? -1.0 : 1.0;
  if (early.size() < kFewest || late.size() < kFewest) return of_a_drive;
  const double before = median(std::move(early)), moved = median(std::move(late)) - before;
  if (std::abs(moved) < kMoved * std::abs(before)) return of_a_drive;
  return net * moved > 0.0 ? 1.0 : -1.0;
}

}  // namespace voltlap::plant
