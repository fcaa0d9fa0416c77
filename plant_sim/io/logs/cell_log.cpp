// SPDX-License-Identifier: Apache-2.0
#include "io/logs/cell_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/plain_columns.hpp"
#include "io/logs/plausible_units.hpp"
#include "io/logs/repairs.hpp"
#include "io/logs/step_clock.hpp"
#include "io/logs/temperature_columns.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;

const RoleSource& needed_role(const RoleMap& map, const std::string& role) {
  if (const RoleSource* from = map.find(role)) return *from;
  throw InputError(map.source, "no role \"" + role + "\"", "roles time, current and voltage (or pack_voltage)",
                   "Add the role to the map");
}

/// A role's column in SI; empty when the map has none.
struct RoleColumn {
  RoleSource source;
  std::vector<double> values;
};

/// An entry for all numbers at once has the role with 1 as well.
std::optional<RoleSource> first_of_numbered(const MeasuredTable& table, const RoleMap& map, const std::string& role) {
  if (!role.ends_with("_1") || map.find(role) != nullptr) return std::nullopt;
  const RoleSource* all = map.find(role.substr(0, role.size() - 1) + "<n>");
  if (all == nullptr || all->frame || !all->index.empty() || !all->file.empty()) return std::nullopt;
  RoleSource out = *all;
  out.column = with_number(all->column, all->first.value_or(1));
  return table.find(out.column) >= 0 ? std::optional(out) : std::nullopt;
}

bool is_counter_role(const std::string& role) {
  return role == "charge_ah" || role == "charged_ah" || role == "discharged_ah";
}

RoleColumn role_column(const MeasuredTable& table, const RoleMap& map, const std::string& role,
                       std::vector<std::string>& said) {
  const std::optional<RoleSource> numbered = first_of_numbered(table, map, role);
  const RoleSource* from = numbered ? &*numbered : map.find(role);
  if (from == nullptr || (from->optional && table.find(from->column) < 0)) return {};
  const std::size_t index = table.index_for(from->column, role, map.source);
  RoleColumn out{with_file_unit(*from, role, table, map.source, said), table.values[index]};
  if (role == "current" && from->discharge == DischargeSign::kAuto) {
    if (const auto signed_by = sign_by_state(table, out.values)) said.push_back(*signed_by);
  }
  for (double& value : out.values) value = value * out.source.scale + out.source.offset;
  if (table.about.empty()) return out;
  const MeasuredColumn& about = table.about[index];
  said.insert(said.end(), about.notes.begin(), about.notes.end());
  const MeasuredColumn::Holes& holes = about.holes;
  if (holes.all() > holes.empty)
    said.push_back(
        fmt::format("{} (\"{}\"): {} fields are no numbers ({})", role, from->column, holes.all(), holes.text()));
  if (holes.all() == table.rows() && role != "temperature_1" && role != "ambient" && !is_counter_role(role)) {
    throw InputError(fmt::format("{}, column \"{}\"", table.path, from->column),
                     fmt::format("no number in any of {} rows ({})", table.rows(), holes.text()),
                     fmt::format("numbers for the role {}", role), "Correct the column in the map, or the file");
  }
  return out;
}

std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> out;
  if (values.empty()) return out;
  VOLTLAP_DEMAND(rows.empty() || *std::max_element(rows.begin(), rows.end()) < values.size());
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

/// What one counter of a tester has counted since row 0; it begins at 0 again with a step, a cycle or a script.
std::vector<double> counted_since_start(const std::vector<double>& counter) {
  constexpr double kRestart = 0.5;  // of its value: what falls by less is rounding
  std::vector<double> out(counter.size(), 0.0);
  double total = 0.0, before = std::nan("");
  for (std::size_t row = 0; row < counter.size(); ++row) {
    const double now = counter[row];
    out[row] = std::isfinite(now) ? total : std::nan("");
    if (!std::isfinite(now)) continue;
    if (std::isfinite(before)) total += now < kRestart * before ? now : now - before;
    out[row] = total;
    before = now;
  }
  return out;
}

/// The net charge, discharge positive, of testers that count what goes in and what comes out by themselves.
std::vector<double> net_charge(const std::vector<double>& charged, const std::vector<double>& discharged) {
  VOLTLAP_DEMAND(charged.size() == discharged.size());
  const std::vector<double> in = counted_since_start(charged), drawn = counted_since_start(discharged);
  std::vector<double> out(in.size());
  std::transform(drawn.begin(), drawn.end(), in.begin(), out.begin(), std::minus<>());
  return out;
}

/// What a recording of one battery holds, row by row of the file, in SI.
struct RowValues {
  std::vector<double> time, current, voltage, temperature, ambient, charge;

  void keep(const std::vector<std::size_t>& rows) {
    for (auto* values : {&time, &current, &voltage, &temperature, &ambient, &charge}) *values = picked(*values, rows);
  }
};

/// Some battery units publish a voltage to which they add current times resistance. Where that does not fall with the
/// discharge current while the bus falls clearly, the bus has the measured one.
bool is_measured_by_bus(const Channel& current, const Channel& pack, const Channel& bus) {
  constexpr double kClear = 0.2, kBusClear = 0.4;
  return sign_evidence(current, pack) > -kClear && sign_evidence(current, bus) < -kBusClear;
}

constexpr const char* kBusIsTaken =
    "pack_voltage does not fall with the discharge current while bus_voltage does: bus_voltage is taken as the "
    "battery's";

/// The role that the battery's voltage is read from. A bus only where the sign of the current is declared: else it
/// would decide what it is to be judged by.
std::string voltage_role(const MeasuredTable& table, const RoleMap& map, const std::vector<double>& time_s,
                         CellLog& log) {
  if (map.find("voltage") != nullptr) return "voltage";
  const RoleSource *source = map.find("current"), *bus = map.find("bus_voltage");
  if (bus == nullptr || source->discharge == DischargeSign::kAuto) return "pack_voltage";
  const auto channel = [&](const char* role) {
    std::vector<std::string> unsaid;
    Channel out;
    out.time_s = time_s;
    out.value = role_column(table, map, role, unsaid).values;
    for (std::size_t row = 0; row < time_s.size(); ++row) {
      if (!std::isfinite(time_s[row])) out.value[row] = std::nan("");
    }
    return out;
  };
  Channel current = channel("current");
  if (source->discharge == DischargeSign::kNegative) {
    for (double& i : current.value) i = -i;
  }
  if (!is_measured_by_bus(current, channel("pack_voltage"), channel("bus_voltage"))) return "pack_voltage";
  log.repairs.emplace_back(kBusIsTaken);
  return "bus_voltage";
}

RowValues values_of(const MeasuredTable& table, const RoleMap& map, const LogOptions& options, CellLog& log) {
  RowValues out;
  static_cast<void>(needed_role(map, "time"));
  static_cast<void>(needed_role(map, "current"));
  if (map.find("voltage") == nullptr) static_cast<void>(needed_role(map, "pack_voltage"));
  RoleColumn time = role_column(table, map, "time", log.repairs);
  settle_clock(time.values, time.source, log);
  out.time = std::move(time.values);
  const std::string volts = voltage_role(table, map, out.time, log);
  out.voltage = role_column(table, map, volts, log.repairs).values;
  RoleColumn current = role_column(table, map, "current", log.repairs);
  settle_current_unit(current.values, out.voltage, current.source, options, log);
  out.current = std::move(current.values);
  out.temperature = role_column(table, map, "temperature_1", log.repairs).values;
  settle_temperature_unit(out.temperature, "temperature_1", log);
  out.ambient = role_column(table, map, "ambient", log.repairs).values;
  settle_temperature_unit(out.ambient, "ambient", log);
  out.charge = role_column(table, map, "charge_ah", log.repairs).values;
  const std::vector<double> in = role_column(table, map, "charged_ah", log.repairs).values,
                            drawn = role_column(table, map, "discharged_ah", log.repairs).values;
  if (out.charge.empty() && !in.empty() && !drawn.empty()) out.charge = net_charge(in, drawn);
  return out;
}

/// The first row after each restart of the recorder begins a part.
void begin_parts(const std::vector<double>& time_s, const std::vector<double>& restarts_s, std::vector<bool>& joined) {
  VOLTLAP_DEMAND(time_s.size() == joined.size());
  for (const double restart_s : restarts_s) {
    const auto row = std::lower_bound(time_s.begin(), time_s.end(), restart_s) - time_s.begin();
    if (row > 0 && row < std::ssize(joined)) joined[static_cast<std::size_t>(row)] = true;
  }
}

CellLog log_of_rows(const MeasuredTable& table, const RoleMap& map, const LogOptions& options,
                    const std::vector<double>& restarts_s) {
  CellLog log;
  log.path = table.path;
  log.map = map.source;
  for (const auto* said : {&table.repairs, &table.notes, &map.notes})
    log.repairs.insert(log.repairs.end(), said->begin(), said->end());
  RowValues values = values_of(table, map, options, log);
  const std::vector<std::size_t> inside = rows_in_window(values.time, options);
  if (inside.size() < values.time.size())
    log.repairs.push_back(fmt::format("window: {} of {} rows", inside.size(), values.time.size()));
  values.keep(inside);
  std::vector<bool> joined;
  const auto rows = rows_in_order(values.time, values.current, log, joined);
  if (rows.size() < 10) {
    throw InputError(table.path, fmt::format("{} usable rows", rows.size()),
                     "at least 10 with time, current and voltage", "Check the columns in the map and --window");
  }
  values.keep(rows);
  log.time_s = std::move(values.time);
  begin_parts(log.time_s, restarts_s, joined);
  log.current_a = std::move(values.current);
  log.voltage_v = std::move(values.voltage);
  log.temperature_c = std::move(values.temperature);
  log.ambient_c = std::move(values.ambient);
  log.charge_ah = std::move(values.charge);
  fill_holes(log.temperature_c, log.time_s, "temperature", log);
  fill_holes(log.ambient_c, log.time_s, "ambient temperature", log);
  fill_holes(log.charge_ah, log.time_s, "charge counter", log);
  for (double& i : log.current_a) i /= options.cells_in_parallel;
  for (double& q : log.charge_ah) q /= options.cells_in_parallel;
  find_gaps(log, joined);
  bring_to_one_cell(log, options.cells_in_series);
  settle_sign(log, needed_role(map, "current").discharge);
  settle_counter(log);
  settle_time_unit(log, map);
  note_held_rows(log);
  VOLTLAP_DEMAND(log.current_a.size() == log.rows() && log.voltage_v.size() == log.rows());
  VOLTLAP_DEMAND(log.gap.size() == log.rows() && !log.gap.front());
  VOLTLAP_DEMAND(increasing(log.time_s) && all_finite(log.time_s) && all_finite(log.current_a));
  VOLTLAP_DEMAND(all_finite(log.temperature_c) && all_finite(log.ambient_c) && all_finite(log.charge_ah));
  return log;
}

}  // namespace

CellLog cell_log_of(const MeasuredTable& table, const RoleMap& map, const LogOptions& options) {
  CellLog log = log_of_rows(table, map, options, {});
  const RoleSource& volts = needed_role(map, map.find("voltage") == nullptr ? "pack_voltage" : "voltage");
  const std::vector<double>& raw = table.values[table.index_for(volts.column, "voltage", map.source)];
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
  if (one_table) {
    MeasuredTable table = read_measured_table(path);
    if (given == nullptr && found.match.empty()) {  // a shipped map says all it means
      add_temperatures(table, found);
      refine_by_step_clock(found, table);
    }
    return cell_log_of(table, map, options);
  }
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
  const Channel &own = needed(pack ? "pack_voltage" : "voltage"), *bus = drive.find("bus_voltage");
  const bool by_bus = pack && bus != nullptr && is_measured_by_bus(current, own, *bus);
  const Channel& voltage = by_bus ? *bus : own;
  MeasuredTable rows;
  rows.path = drive.path;
  std::vector<double> times;
  std::set_union(current.time_s.begin(), current.time_s.end(), voltage.time_s.begin(), voltage.time_s.end(),
                 std::back_inserter(times));
  times.erase(std::unique(times.begin(), times.end()), times.end());
  RoleMap plain;
  plain.source = drive.map;
  const auto add = [&](const char* role, std::vector<double> values) {
    plain.roles[role] = {role, 1.0, 0.0, DischargeSign::kAuto, "SI"};
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
  plain.roles["time"].unit = "s";
  plain.roles["current"].discharge =
      drive.declared == DischargeSign::kAuto ? DischargeSign::kAuto : DischargeSign::kPositive;
  rows.lines.resize(times.size());
  CellLog log = log_of_rows(rows, plain, options, drive.restarts_s);
  for (const LogDefect& defect : drive.defects) log.repairs.push_back(defect.text);
  for (const std::string& note : drive.notes) log.repairs.push_back(note);
  if (by_bus) log.repairs.emplace_back(kBusIsTaken);
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
