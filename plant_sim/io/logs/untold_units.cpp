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
  const SignalCandidate candidate(clock);
  const double first = candidate.low(), last = candidate.high();
  if (!(first > kFirst && last < kLast && last - first < 1.0)) return false;
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
  const RecordedSignal *current = signal_of(table, map, "current"), *voltage = nullptr;
  for (const char* role : {"pack_voltage", "voltage", "cell_voltage_1"}) {
    if (voltage == nullptr) voltage = signal_of(table, map, role);
  }
  if (current == nullptr || voltage == nullptr || !is_in_milliseconds(*clock, *current, *voltage)) return;
  take_unit(map, "time", "ms", 1e-3, "in s the charge of the log would have moved the voltage");
}

/// Of the cell that a voltage stands for: V = a - R I by least squares, over the rows as they are and over their steps.
double resistance_ohm(const RecordedSignal& current, const RecordedSignal& voltage) {
  double count = 0.0, i = 0.0, v = 0.0, ii = 0.0, iv = 0.0, steps = 0.0, with = 0.0;
  double last_i = std::nan(""), last_v = std::nan("");
  for (std::size_t row = 0; row < std::min(current.value.size(), voltage.value.size()); ++row) {
    const double amps = current.value[row], volts = voltage.value[row];
    if (!std::isfinite(amps) || !std::isfinite(volts)) continue;
    ++count, i += amps, v += volts, ii += amps * amps, iv += amps * volts;
    if (std::isfinite(last_i)) {
      steps += (amps - last_i) * (amps - last_i);
      with += (amps - last_i) * (volts - last_v);
    }
    last_i = amps;
    last_v = volts;
  }
  const double by_rows = std::abs(iv - i * v / count) / (ii - i * i / count);
  return std::fmax(by_rows, steps > 0.0 ? std::abs(with) / steps : 0.0);
}

/// The largest that any voltage of the table shows: one that is slow or coarse shows too little.
double cell_resistance_ohm(const RecordedSignals& table, const RoleMap& map, const RecordedSignal& current) {
  constexpr double kUsualCell_v = 3.7;
  double out = std::nan("");
  for (const char* role : {"pack_voltage", "bus_voltage", "voltage", "cell_voltage_1"}) {
    const RecordedSignal* voltage = signal_of(table, map, role);
    if (voltage == nullptr) continue;
    const double scale = map.roles.at(role).scale;
    const double cells = std::max(1.0, scale * SignalCandidate(*voltage).middle() / kUsualCell_v);
    out = std::fmax(out, scale * resistance_ohm(current, *voltage) / cells);
  }
  return out;
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
    constexpr double kMany_a = 1000.0, kLeast_ohm = 2e-5;  // a group of cells has more, a car rarely carries as much
    const double ohm = cell_resistance_ohm(table, map, *current);
    if (most > role_range("current").max) {
      take_unit(map, "current", "mA", 1e-3, "no car carries as many amperes");
    } else if (most > kMany_a && ohm < kLeast_ohm) {
      take_unit(map, "current", "mA", 1e-3, fmt::format("a cell would have {:.2g} mOhm", 1e3 * ohm));
    }
  }
}

}  // namespace voltlap::plant
