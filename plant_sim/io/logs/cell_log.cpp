// SPDX-License-Identifier: Apache-2.0
#include "io/logs/cell_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/repairs.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;

std::vector<double> column(const MeasuredTable& table, const RoleMap& map, const std::string& role, bool needed) {
  const RoleSource* from = map.find(role);
  if (from == nullptr) {
    if (!needed) return {};
    throw InputError(map.source, "no role \"" + role + "\"", "roles time, current and voltage (or pack_voltage)",
                     "Add the role to the map");
  }
  const int index = table.find(from->column);
  if (index < 0) {
    throw InputError(table.path, fmt::format("no column \"{}\"", from->column),
                     fmt::format("that column for the role {} ({})", role, map.source),
                     "Correct the map or the file");
  }
  std::vector<double> out = table.values[static_cast<std::size_t>(index)];
  for (double& value : out) value = value * from->scale + from->offset;
  return out;
}

std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> out;
  if (values.empty()) return out;
  VOLTLAP_DEMAND(rows.empty() || rows.back() < values.size());
  out.reserve(rows.size());
  for (const std::size_t row : rows) out.push_back(values[row]);
  return out;
}

std::vector<std::size_t> rows_in_window(const std::vector<double>& time, const LogOptions& options) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < time.size(); ++row) {
    const bool outside = time[row] < options.window_begin_s || time[row] > options.window_end_s;
    if (!outside) rows.push_back(row);
  }
  return rows;
}

}  // namespace

const char* name_of(CurrentHold hold) {
  switch (hold) {
    case CurrentHold::kPrevious:
      return "of each row held until the next";
    case CurrentHold::kNext:
      return "of each row held since the one before";
    default:
      return "straight between rows";
  }
}

namespace {

CellLog log_of_rows(const MeasuredTable& table, const RoleMap& map, const LogOptions& options) {
  CellLog log;
  log.path = table.path;
  log.map = map.source;
  log.repairs = table.repairs;
  std::vector<double> time = column(table, map, "time", true);
  std::vector<double> current = column(table, map, "current", true);
  const bool pack = map.find("voltage") == nullptr;
  const std::vector<double> voltage = column(table, map, pack ? "pack_voltage" : "voltage", true);
  const std::vector<std::size_t> inside = rows_in_window(time, options);
  if (inside.size() < time.size())
    log.repairs.push_back(fmt::format("window: {} of {} rows", inside.size(), time.size()));
  time = picked(time, inside);
  current = picked(current, inside);
  std::vector<bool> joined;
  const auto rows = rows_in_order(time, current, log, joined);
  if (rows.size() < 10) {
    throw InputError(table.path, fmt::format("{} usable rows", rows.size()),
                     "at least 10 with time, current and voltage", "Check the columns in the map and --window");
  }
  log.time_s = picked(time, rows);
  log.current_a = picked(current, rows);
  log.voltage_v = picked(picked(voltage, inside), rows);
  log.temperature_c = picked(picked(column(table, map, "temperature_1", false), inside), rows);
  log.ambient_c = picked(picked(column(table, map, "ambient", false), inside), rows);
  log.charge_ah = picked(picked(column(table, map, "charge_ah", false), inside), rows);
  for (double& i : log.current_a) i /= options.cells_in_parallel;
  for (double& q : log.charge_ah) q /= options.cells_in_parallel;
  find_gaps(log, joined);
  bring_to_one_cell(log, options.cells_in_series);
  const RoleSource* sign = map.find("current");
  settle_sign(log, sign->discharge);
  settle_counter(log);
  note_held_rows(log);
  VOLTLAP_DEMAND(log.current_a.size() == log.rows() && log.voltage_v.size() == log.rows());
  VOLTLAP_DEMAND(log.gap.size() == log.rows() && !log.gap.front());
  return log;
}

}  // namespace

CellLog cell_log_of(const MeasuredTable& table, const RoleMap& map, const LogOptions& options) {
  CellLog log = log_of_rows(table, map, options);
  const std::vector<double> raw = column(table, map, map.find("voltage") == nullptr ? "pack_voltage" : "voltage", true);
  const auto holes = std::count_if(raw.begin(), raw.end(), [](double v) { return !std::isfinite(v); });
  if (holes > 0) log.repairs.push_back(fmt::format("{} rows without a voltage are not used", holes));
  return log;
}

CellLog read_cell_log(const std::string& path, const RoleMap* given, const DataFolder& data,
                      const LogOptions& options) {
  RoleMap found;
  if (given == nullptr) found = role_map_for_recording(path, data);
  const RoleMap& map = given != nullptr ? *given : found;
  const bool one_table = std::none_of(map.roles.begin(), map.roles.end(), [](const auto& role) {
    return role.second.frame.has_value() || !role.second.file.empty();
  });
  if (one_table) return cell_log_of(read_measured_table(path), map, options);
  return cell_log_of(read_drive_log(path, &map, data), options);
}

CellLog cell_log_of(const DriveLog& drive, const LogOptions& options) {
  const auto needed = [&](const char* role) -> const Channel& {
    if (const Channel* channel = drive.find(role)) return *channel;
    throw InputError(drive.path, fmt::format("no usable role \"{}\"", role),
                     "roles current and voltage (or pack_voltage)", "Add the role to the map " + drive.map);
  };
  const bool pack = drive.find("voltage") == nullptr;
  const Channel& current = needed("current");
  const Channel& voltage = needed(pack ? "pack_voltage" : "voltage");
  MeasuredTable rows;
  rows.path = drive.path;
  std::vector<double> times;
  std::set_union(current.time_s.begin(), current.time_s.end(), voltage.time_s.begin(), voltage.time_s.end(),
                 std::back_inserter(times));
  times.erase(std::unique(times.begin(), times.end()), times.end());
  RoleMap plain;
  plain.source = drive.map;
  const auto add = [&](const char* role, std::vector<double> values) {
    plain.roles[role] = {role};
    rows.columns.emplace_back(role);
    rows.values.push_back(std::move(values));
  };
  add("time", times);
  // A row for each sample of either: the current holds until its next sample, a voltage stands in its own row only.
  constexpr double kLongestHold = 5.0, kSlowHold = 60.0;  // s
  add("current", held_at(current, times, kLongestHold));
  add(pack ? "pack_voltage" : "voltage", held_at(voltage, times, 0.0));
  for (const char* role : {"temperature_1", "ambient", "charge_ah"}) {
    if (const Channel* channel = drive.find(role)) add(role, held_at(*channel, times, kSlowHold));
  }
  plain.roles["current"].discharge =
      drive.declared == DischargeSign::kAuto ? DischargeSign::kAuto : DischargeSign::kPositive;
  rows.lines.resize(times.size());
  CellLog log = log_of_rows(rows, plain, options);
  for (const LogDefect& defect : drive.defects) log.repairs.push_back(defect.text);
  for (const std::string& note : drive.notes) log.repairs.push_back(note);
  return log;
}

std::vector<double> charge_drawn_ah(const CellLog& log, CurrentHold hold) {
  VOLTLAP_DEMAND(log.current_a.size() == log.rows() && log.gap.size() == log.rows());
  VOLTLAP_DEMAND(log.charge_ah.empty() || log.charge_ah.size() == log.rows());
  std::vector<double> drawn(log.rows(), 0.0);
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const double a = hold == CurrentHold::kNext ? log.current_a[row] : log.current_a[row - 1];
    const double b = hold == CurrentHold::kPrevious ? log.current_a[row - 1] : log.current_a[row];
    double step = 0.5 * (a + b) * (log.time_s[row] - log.time_s[row - 1]) / kSecondsPerHour;
    if (log.gap[row]) step = log.charge_ah.empty() ? 0.0 : log.charge_ah[row] - log.charge_ah[row - 1];
    drawn[row] = drawn[row - 1] + step;
  }
  return drawn;
}

std::vector<HoldEvidence> hold_from_counter(const CellLog& log) {
  if (log.charge_ah.empty()) return {};
  VOLTLAP_DEMAND(log.charge_ah.size() == log.rows() && log.gap.size() == log.rows());
  HoldEvidence out{};
  double sum[3] = {}, count = 0.0, finest = 1e300;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const double counted = log.charge_ah[row] - log.charge_ah[row - 1],
                 hours = (log.time_s[row] - log.time_s[row - 1]) / kSecondsPerHour;
    if (log.gap[row] || !std::isfinite(counted) || log.current_a[row] == log.current_a[row - 1]) continue;
    const double a = log.current_a[row - 1] * hours, b = log.current_a[row] * hours;
    const double candidates[3] = {a, b, 0.5 * (a + b)};
    for (int k = 0; k < 3; ++k) sum[k] += (counted - candidates[k]) * (counted - candidates[k]);
    if (counted != 0.0) finest = std::min(finest, std::abs(counted));
    count += 1.0;
  }
  if (count < 50.0) return {};
  for (int k = 0; k < 3; ++k) out.rms_ah[k] = std::sqrt(sum[k] / count);
  const auto best = std::min_element(out.rms_ah, out.rms_ah + 3);
  out.hold = static_cast<CurrentHold>(best - out.rms_ah);
  // A counter that cannot see the difference beyond a tenth says nothing.
  for (int k = 0; k < 3; ++k) {
    if (out.rms_ah + k != best && out.rms_ah[k] < 1.1 * *best) return {};
  }
  return {out};
}

}  // namespace voltlap::plant
