// SPDX-License-Identifier: Apache-2.0
#include "io/logs/untold_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/errors.hpp"
#include "io/logs/battery_pair.hpp"
#include "io/logs/signal_candidate.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMostPack_v = 2000.0;  // no car's pack has more

bool is_untold(const RoleSource& source) {
  return (source.unit.empty() || source.unit == "1") && source.scale == 1.0 && source.offset == 0.0;
}

const RecordedSignal* signal_of(const RecordedSignals& table, const RoleMap& map, const std::string& role) {
  const RoleSource* source = map.find(role);
  if (source == nullptr) return nullptr;
  const auto at = std::find_if(table.signals.begin(), table.signals.end(),
                               [&](const RecordedSignal& s) { return s.source.column == source->column; });
  return at == table.signals.end() ? nullptr : &*at;
}

/// The column of a role whose unit neither file nor map tells; nullptr for none.
const RecordedSignal* untold_signal_of(const RecordedSignals& table, const RoleMap& map, const std::string& role) {
  const RecordedSignal* signal = signal_of(table, map, role);
  return signal == nullptr || signal->unit || !is_untold(map.roles.at(role)) ? nullptr : signal;
}

void take_unit(RoleMap& map, const std::string& role, const std::string& name, double scale, const std::string& why) {
  RoleSource& source = map.roles.at(role);
  source.unit = name;
  source.scale = scale;
  map.notes.push_back(fmt::format("\"{}\" is in {}, which nobody says: {}", source.column, name, why));
}

/// 20260614115940 is a date, and no number of anything.
void refuse_compact_date(const RecordedSignals& table, const RecordedSignal& clock) {
  constexpr double kFirst = 19700101000000.0, kLast = 21000101000000.0;
  const double middle = SignalCandidate(clock).middle();
  if (!(middle > kFirst && middle < kLast)) return;
  throw InputError(fmt::format("{}, column \"{}\"", table.path, clock.label),
                   fmt::format("{:.0f}, a date and time written as one number", middle),
                   "seconds, or a stamp such as 2026-06-14 11:59:40", "Write the column in one of these forms");
}

/// Days of a spreadsheet, which count from 1900.
bool settle_days(const RecordedSignal& clock, RoleMap& map) {
  constexpr double kFirst = 25569.0, kLast = 73050.0, kDay_s = 86400.0;  // 1970 to 2099
  const auto [first, last] = std::minmax_element(clock.value.begin(), clock.value.end());
  if (clock.value.empty() || !(*first > kFirst && *last < kLast && *last - *first < 1.0)) return false;
  take_unit(map, "time", "days", kDay_s, "the log would be shorter than a second, far from its zero");
  return true;
}

/// A clock since 1970 in parts of a second; true when it is one.
bool settle_since_1970(const RecordedSignal& clock, RoleMap& map) {
  struct Since {
    double least, scale;
    const char* name;
  };
  // 1e11 s are the year 5138, 1e11 ms the year 1973.
  constexpr std::array kUnits{Since{1e17, 1e-9, "ns"}, Since{1e14, 1e-6, "us"}, Since{1e11, 1e-3, "ms"}};
  const double middle = SignalCandidate(clock).middle();
  for (const auto& [least, scale, name] : kUnits) {
    if (!(middle > least)) continue;
    take_unit(map, "time", name, scale, "as seconds since 1970 it would lie beyond the year 5000");
    return true;
  }
  return false;
}

void settle_time(const RecordedSignals& table, RoleMap& map) {
  const RecordedSignal* clock = untold_signal_of(table, map, "time");
  if (clock == nullptr) return;
  refuse_compact_date(table, *clock);
  if (settle_since_1970(*clock, map) || settle_days(*clock, map)) return;
  BatteryPair pair;
  pair.current = signal_of(table, map, "current");
  for (const char* role : {"voltage", "pack_voltage", "cell_voltage_1"}) {
    if (pair.voltage == nullptr) pair.voltage = signal_of(table, map, role);
  }
  pair.is_clear = true;
  const TimeUnits units = time_units(table, *clock, pair);
  if (units.possible.size() != 1 || units.possible.front() == "s") return;
  const std::string& unit = units.possible.front();
  take_unit(map, "time", unit, unit == "ms" ? 1e-3 : unit == "min" ? 60.0 : 3600.0, units.why);
}

/// Of a cell, by the steps from row to row; unknown without steps.
double cell_resistance_ohm(const RecordedSignals& table, const RoleMap& map) {
  constexpr double kUsualCell_v = 3.7;
  const RecordedSignal* current = signal_of(table, map, "current");
  double cells = 1.0, with = 0.0, squares = 0.0;
  const RecordedSignal* voltage = nullptr;
  for (const char* role : {"cell_voltage_1", "voltage", "pack_voltage"}) {
    if (voltage != nullptr || signal_of(table, map, role) == nullptr) continue;
    voltage = signal_of(table, map, role);
    cells = std::max(1.0, map.roles.at(role).scale * SignalCandidate(*voltage).middle() / kUsualCell_v);
  }
  if (current == nullptr || voltage == nullptr) return std::nan("");
  for (std::size_t row = 1; row < std::min(current->value.size(), voltage->value.size()); ++row) {
    const double di = current->value[row] - current->value[row - 1], dv = voltage->value[row] - voltage->value[row - 1];
    if (!std::isfinite(di) || !std::isfinite(dv)) continue;
    with += di * dv;
    squares += di * di;
  }
  return squares > 0.0 ? std::abs(with) / squares / cells : std::nan("");
}

}  // namespace

void settle_untold_units(const RecordedSignals& table, RoleMap& map) {
  settle_time(table, map);
  for (const char* role : {"voltage", "pack_voltage", "bus_voltage"}) {
    const RecordedSignal* voltage = untold_signal_of(table, map, role);
    if (voltage == nullptr) continue;
    if (SignalCandidate(*voltage).middle() > kMostPack_v) {
      take_unit(map, role, "mV", 1e-3, "no car has as many volts");
    }
  }
  if (const RecordedSignal* current = untold_signal_of(table, map, "current")) {
    const SignalCandidate candidate(*current);
    const double most = std::max(std::abs(candidate.low()), std::abs(candidate.high()));
    constexpr double kFew_a = 500.0, kLeast_ohm = 2e-5;  // a group of cells has more, a car with so little carries more
    const double ohm = cell_resistance_ohm(table, map);
    if (most > role_range("current").max) {
      take_unit(map, "current", "mA", 1e-3, "no car carries as many amperes");
    } else if (most > kFew_a && ohm < kLeast_ohm) {
      take_unit(map, "current", "mA", 1e-3, fmt::format("a cell would have {:.2g} mOhm", 1e3 * ohm));
    }
  }
}

}  // namespace voltlap::plant
