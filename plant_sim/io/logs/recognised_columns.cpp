// SPDX-License-Identifier: Apache-2.0
// Which of the columns that cyclers and loggers write is which role.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/plain_columns.hpp"
#include "io/logs/role_source.hpp"
#include "io/logs/signal_words.hpp"

namespace voltlap::plant {
namespace {

using Names = std::vector<std::string_view>;

/// Names in lower case without units, the best first: of several that a table has the best is taken.
struct RoleNames {
  std::string_view role;
  Quantity quantity;
  std::array<Names, 4> tiers;
};

// Arbin Test_Time(s), Date_Time, Step_Time(s), Current(A), Voltage(V); Maccor TestTime, Amps, Volts, DPt Time;
// BioLogic time/s, I/mA or <I>/mA, Ecell/V or Ewe/V, (Q-Qo)/mA.h; Digatron Prog Time, Spannung, Strom, AhAccu; Basytec
// ~Time[h], I[A], U[V], T1[°C], Ah[Ah]; Neware Time(h:min:s.ms), Total Time, Cur(mA), Realtime; the Chinese names are
// test, total, absolute and relative time, current, voltage, capacity, temperature.
const std::array<RoleNames, 9> kRoleNames{
    RoleNames{"time",
              Quantity::kTime,
              {Names{"test time", "testtime", "test", "total time", "totaltime", "elapsed time", "elapsed", "run time",
                     "prog time", "programmdauer", "prog dauer", "prüfzeit", "laufzeit", "gesamtzeit", "测试时间",
                     "总时间", "累计时间"},
               Names{"time", "t", "zeit", "seconds", "sec", "s", "时间", "temps", "tiempo"},
               Names{"date time", "datetime", "date time s", "date", "timestamp", "time stamp", "zeitstempel",
                     "absolute time", "abs time", "real time", "realtime", "dpt time", "datum", "datum zeit", "utc",
                     "system time", "系统时间", "绝对时间", "日期"},
               Names{"relative time", "step time", "steptime", "rec time", "record time", "schrittzeit", "schrittdauer",
                     "相对时间", "步时间"}}},
    RoleNames{"current",
              Quantity::kCurrent,
              {Names{"current", "i", "a", "amps", "amp", "cur", "curr", "strom", "pack current", "battery current",
                     "cell current", "batteriestrom", "zellstrom", "i batt", "i bat", "ibat", "ibatt", "i pack",
                     "ipack", "i cell", "icell", "hv current", "measured current", "current measured", "dc current",
                     "courant", "corriente", "corrente", "电流"},
               Names{}, Names{}, Names{}}},
    RoleNames{"voltage",
              Quantity::kVoltage,
              {Names{"voltage", "v", "u", "volts", "volt", "spannung", "ecell", "cell voltage", "zellspannung",
                     "terminal voltage", "klemmenspannung", "measured voltage", "voltage measured", "v cell", "vcell",
                     "u cell", "ucell", "cell v", "tension", "voltaje", "tensione", "电压"},
               Names{"ewe", "potential"}, Names{}, Names{}}},
    RoleNames{"pack_voltage",
              Quantity::kVoltage,
              {Names{"pack voltage", "pack v", "packspannung", "battery voltage", "batteriespannung", "total voltage",
                     "hv voltage", "v pack", "vpack", "u pack", "upack", "v batt", "vbatt", "v bat", "vbat", "u batt",
                     "ubatt", "u bat", "ubat", "总电压"},
               Names{}, Names{}, Names{}}},
    RoleNames{"temperature_1",
              Quantity::kTemperature,
              {Names{"cell temperature", "cell temp", "t cell", "tcell", "zelltemperatur", "surface temperature",
                     "t surface", "battery temperature", "aux temperature 1", "temperature 1", "temp 1", "temp1", "t1",
                     "aux t1", "aux.t1", "auxt1", "température cellule"},
               Names{"temperature", "temp", "temperatur", "température", "temperatura", "温度"},
               Names{"t", "theta", "ϑ", "θ"},  // a letter: only with a unit of temperature
               Names{}}},
    RoleNames{"ambient",
              Quantity::kTemperature,
              {Names{"ambient", "ambient temperature", "ambient temp", "chamber temperature", "chamber temp", "t amb",
                     "tamb", "t ambient", "umgebung", "umgebungstemperatur", "kammertemperatur", "t chamber"},
               Names{}, Names{}, Names{}}},
    RoleNames{"charge_ah",
              Quantity::kCharge,
              {Names{"q qo", "ah accu", "ahaccu", "charge ah", "net capacity", "ladungsbilanz"},
               Names{"capacity", "charge", "q", "ah", "amp hr", "ladung", "kapazität", "容量"}, Names{}, Names{}}},
    RoleNames{"charged_ah",
              Quantity::kCharge,
              {Names{"charge capacity", "charged capacity", "chg capacity", "chg cap", "chg ah", "charge ah",
                     "q charge", "ladekapazität", "充电容量"},
               Names{}, Names{}, Names{}}},
    RoleNames{"discharged_ah",
              Quantity::kCharge,
              {Names{"discharge capacity", "discharged capacity", "dchg capacity", "dchg cap", "dis ah",
                     "discharge ah", "q discharge", "entladekapazität", "放电容量"},
               Names{}, Names{}, Names{}}},
};

// A name that says current or voltage among other words; not with these.
constexpr auto kNotMeasured = std::to_array<std::string_view>(
    {"limit", "max", "min", "set", "ref", "target", "command", "cmd", "request", "phase", "heater", "aux", "dcl",
     "ccl", "charger", "12v", "low", "lv", "control", "end", "cut", "avg", "average", "sensor", "dv", "delta",
     "motor", "pump", "fan", "supply", "ripple", "error", "offset", "soll"});

constexpr std::array<std::string_view, 6> kPack{"pack", "batt", "total", "hv", "akku", "accu"};  // whose a voltage is
constexpr std::array<std::string_view, 6> kNotThePack{"cell", "zell", "bus", "link", "inv", "zwischenkreis"};

struct Candidate {
  std::size_t column = 0;
  NamedUnit unit;
  bool unit_told = false;
};

/// The column as a source of that quantity; nothing when the file gives it a unit of another.
std::optional<Candidate> candidate_of(const MeasuredTable& table, std::size_t column, Quantity quantity) {
  auto unit = file_unit(table, column);
  if (!unit) unit = unit_named(column_name(table.columns[column]).unit);  // a letter: I_A, with a name that fits
  if (unit && unit->quantity != quantity) return std::nullopt;
  if (unit) return Candidate{column, *unit, true};
  return Candidate{column, NamedUnit{"", quantity}, false};
}

bool has_numbers(const MeasuredTable& table, std::size_t column) {
  if (!table.about.empty() && !table.about[column].unreadable.empty()) return true;  // it says so when it is used
  const auto& values = table.values[column];
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool same_values(const MeasuredTable& table, const Candidate& a, const Candidate& b) {
  const auto& x = table.values[a.column];
  const auto& y = table.values[b.column];
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double first = x[row] * a.unit.scale, second = y[row] * b.unit.scale;
    if (std::isnan(first) && std::isnan(second)) continue;
    if (!(std::abs(first - second) <= 1e-3 * std::max(std::abs(first), std::abs(second)))) return false;
  }
  return true;
}

[[noreturn]] void refuse_both(const MeasuredTable& table, std::string_view role, const Candidate& a,
                              const Candidate& b) {
  const char* usual = role == "time" ? "s" : role == "current" ? "A" : role.ends_with("voltage") ? "V" : "1";
  const std::string unit = a.unit_told ? std::string(a.unit.name) : usual;
  const auto called = [&](const Candidate& c) {
    return fmt::format("column {}, \"{}\"", c.column + 1, table.columns[c.column]);
  };
  throw InputError(table.path, fmt::format("{}, and {} for the role {}", called(a), called(b), role),
                   "one column for each role",
                   fmt::format("Say which in a map (--map), such as {} = {{column = \"{}\", unit = \"{}\"}}; two of "
                               "the same name need other names in the file.",
                               role, table.columns[a.column], unit));
}

/// Which is a temperature only where a unit says so: a time, an angle else.
bool is_letter(std::string_view name) {
  const Names letters{"t", "theta", "ϑ", "θ"};
  return std::find(letters.begin(), letters.end(), name) != letters.end();
}

std::vector<Candidate> named(const MeasuredTable& table, const Names& names, Quantity quantity) {
  std::vector<Candidate> out;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string name = column_name(table.columns[k]).name;
    if (std::find(names.begin(), names.end(), name) == names.end() || !has_numbers(table, k)) continue;
    const auto candidate = candidate_of(table, k, quantity);
    if (!candidate || (quantity == Quantity::kTemperature && is_letter(name) && !candidate->unit_told)) continue;
    out.push_back(*candidate);
  }
  return out;
}

/// By a word in the name, where no name fits as a whole: "BMS Pack Current".
std::vector<Candidate> worded(const MeasuredTable& table, const Names& words, Quantity quantity) {
  std::vector<Candidate> out;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string name = " " + column_name(table.columns[k]).name + " ";
    const auto in = [&](std::string_view word) { return name.find(word) != std::string::npos; };
    const auto in_as_word = [&](std::string_view word) { return in(" " + std::string(word)); };
    if (std::none_of(words.begin(), words.end(), in) || !has_numbers(table, k)) continue;
    if (std::any_of(kNotMeasured.begin(), kNotMeasured.end(), in_as_word)) continue;
    if (const SpokenName spoken = spoken_name(table.columns[k]); !spoken.is_actual || spoken.is_others) continue;
    if (const auto candidate = candidate_of(table, k, quantity)) out.push_back(*candidate);
  }
  return out;
}

/// The first unless two differ.
std::optional<Candidate> only(const MeasuredTable& table, std::string_view role, const std::vector<Candidate>& all) {
  if (all.empty()) return std::nullopt;
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (!same_values(table, all[0], all[k])) refuse_both(table, role, all[0], all[k]);
  }
  return all.front();
}

std::optional<Candidate> best_named(const MeasuredTable& table, const RoleNames& names) {
  for (const Names& tier : names.tiers) {
    if (const auto found = only(table, names.role, named(table, tier, names.quantity))) return found;
  }
  return std::nullopt;
}

std::size_t backward_steps(const std::vector<double>& time) {
  std::size_t count = 0;
  for (std::size_t row = 1; row < time.size(); ++row) count += time[row] < time[row - 1] ? 1 : 0;
  return count;
}

/// A clock of the step begins again with each; where a column of dates runs on, that one is the time.
std::optional<Candidate> time_column(const MeasuredTable& table) {
  const RoleNames& names = kRoleNames.front();
  const auto found = best_named(table, names);
  if (!found || backward_steps(table.values[found->column]) == 0) return found;
  const auto dates = named(table, names.tiers[2], names.quantity);
  for (const Candidate& date : dates) {
    if (backward_steps(table.values[date.column]) == 0) return date;
  }
  return found;
}

/// A counter that resets with each step, or counts both ways up, is none of the net charge.
bool follows_current(const MeasuredTable& table, const RoleMap& map, const Candidate& counter) {
  VOLTLAP_DEMAND(counter.column < table.columns.size());
  const auto& time = table.values[table.index_for(map.roles.at("time").column, "time", map.source)];
  std::vector<double> current = table.values[table.index_for(map.roles.at("current").column, "current", map.source)];
  static_cast<void>(sign_by_state(table, current));
  const auto& q = table.values[counter.column];
  double with = 0.0, counted = 0.0, integrated = 0.0;
  for (std::size_t row = 1; row < table.rows(); ++row) {
    const double step = q[row] - q[row - 1];
    const double drawn = 0.5 * (current[row] + current[row - 1]) * (time[row] - time[row - 1]);
    if (!std::isfinite(step) || !std::isfinite(drawn)) continue;
    with += step * drawn;
    counted += step * step;
    integrated += drawn * drawn;
  }
  return counted > 0.0 && integrated > 0.0 && std::abs(with) > 0.9 * std::sqrt(counted * integrated);
}

RoleSource source_of(const MeasuredTable& table, const Candidate& candidate) {
  return {table.columns[candidate.column], candidate.unit.scale, candidate.unit.offset, DischargeSign::kAuto,
          std::string(candidate.unit.name)};
}

/// Columns whose names differ in a number alone, three and more: cells, of which none is the battery's voltage.
bool is_of_family(const MeasuredTable& table, std::size_t column) {
  constexpr std::ptrdiff_t kMany = 3;
  const auto pattern = [&](const std::string& label) {
    std::string out;
    bool number = false;
    for (const char c : column_name(label).name) {
      const bool digit = c >= '0' && c <= '9';
      if (!digit || !number) out += digit ? '#' : c;
      number = digit;
    }
    return out;
  };
  const std::string own = pattern(table.columns[column]);
  return own.find('#') != std::string::npos &&
         std::count_if(table.columns.begin(), table.columns.end(),
                       [&](const std::string& other) { return pattern(other) == own; }) >= kMany;
}

/// The voltage of the cell, or of the pack; both in one table would leave open which is meant.
void add_voltage(const MeasuredTable& table, RoleMap& map) {
  std::optional<Candidate> cell = best_named(table, kRoleNames[2]), pack = best_named(table, kRoleNames[3]);
  if (!cell && !pack) {
    auto all = worded(table, {"voltage", "spannung", "volt", "电压"}, Quantity::kVoltage);
    std::erase_if(all, [&](const Candidate& c) { return is_of_family(table, c.column); });
    const auto found = only(table, "voltage", all);
    if (!found) return;
    const std::string name = column_name(table.columns[found->column]).name;
    const auto in = [&](std::string_view word) { return name.find(word) != std::string::npos; };
    (!in("cell") && std::any_of(kPack.begin(), kPack.end(), in) ? pack : cell) = found;
  }
  if (cell && pack && !same_values(table, *cell, *pack)) refuse_both(table, "voltage", *cell, *pack);
  const Candidate& voltage = cell ? *cell : *pack;
  map.roles[cell ? "voltage" : "pack_voltage"] = source_of(table, voltage);
}

/// The pack's voltage beside cells: by its name, by words that say whose it is, or a voltage beyond any cell's. Nothing
/// where two that differ could be it.
std::optional<Candidate> pack_voltage_beside_cells(const MeasuredTable& table, const RoleMap& map) {
  const auto free = [&](std::vector<Candidate> all) {
    std::erase_if(all, [&](const Candidate& c) {
      return is_of_family(table, c.column) ||
             std::any_of(map.roles.begin(), map.roles.end(),
                         [&](const auto& entry) { return entry.second.column == table.columns[c.column]; });
    });
    return all;
  };
  const auto unlike = [&](const std::vector<Candidate>& all) {
    return std::any_of(all.begin(), all.end(), [&](const Candidate& c) { return !same_values(table, all[0], c); });
  };
  const auto says_whose = [&](const Candidate& c) {
    const std::string name = column_name(table.columns[c.column]).name;
    const auto in = [&](std::string_view word) { return name.find(word) != std::string::npos; };
    return std::none_of(kNotThePack.begin(), kNotThePack.end(), in) && std::any_of(kPack.begin(), kPack.end(), in);
  };
  std::vector<Candidate> worded_so = worded(table, {"voltage", "spannung", "volt", "电压"}, Quantity::kVoltage);
  std::erase_if(worded_so, [&](const Candidate& c) { return !says_whose(c); });
  std::vector<Candidate> voltages = named(table, kRoleNames[2].tiers[0], Quantity::kVoltage);
  std::erase_if(voltages, [&](const Candidate& c) {
    std::vector<double> values = table.values[c.column];
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    return !(median(std::move(values)) * c.unit.scale > role_range("cell_voltage_1").max);
  });
  for (const auto& tier : {named(table, kRoleNames[3].tiers[0], Quantity::kVoltage), worded_so, voltages}) {
    const std::vector<Candidate> all = free(tier);
    if (!all.empty()) return unlike(all) ? std::nullopt : std::optional(all.front());
  }
  return std::nullopt;
}

/// It only grows, but where it begins anew; one that has nothing to count stands still.
bool is_one_way(const MeasuredTable& table, const Candidate& counter) {
  constexpr double kRestart = 0.5, kRounding = 1e-3;  // of its value; of the largest
  const auto& q = table.values[counter.column];
  double before = 0.0, most = 0.0;
  for (const double value : q) most = std::isfinite(value) ? std::max(most, value) : most;
  for (const double value : q) {
    if (!std::isfinite(value)) continue;
    if (value < -kRounding * most) return false;
    if (value < before - kRounding * most && value > kRestart * before) return false;
    before = value;
  }
  return true;
}

bool counts(const MeasuredTable& table, const Candidate& counter) {
  const auto& q = table.values[counter.column];
  return std::any_of(q.begin(), q.end(), [](double value) { return std::isfinite(value) && value > 0.0; });
}

/// Testers that count what goes in and what comes out: only both together tell the net charge.
void add_counter_pair(const MeasuredTable& table, RoleMap& map) {
  if (map.find("charge_ah") != nullptr) return;
  const auto counter = [&](const RoleNames& names) -> std::optional<Candidate> {
    const auto all = named(table, names.tiers[0], names.quantity);
    if (all.size() != 1 || !is_one_way(table, all[0])) return std::nullopt;
    return all[0];
  };
  const auto in = counter(kRoleNames[7]), out = counter(kRoleNames[8]);
  if (!in || !out || (!counts(table, *in) && !counts(table, *out))) return;
  map.roles["charged_ah"] = source_of(table, *in);
  map.roles["discharged_ah"] = source_of(table, *out);
}

void note_columns(RoleMap& map) {
  std::vector<std::string> parts;
  for (const auto& [role, source] : map.roles) {
    parts.push_back(fmt::format("{} from \"{}\"{}", role, source.column,
                                source.unit.empty() ? std::string(", no unit given") : " in " + source.unit));
  }
  map.notes.push_back(fmt::format("columns recognised by their names: {}", fmt::join(parts, "; ")));
}

}  // namespace

void add_pack_voltage(const MeasuredTable& table, RoleMap& map) {
  if (map.find("cell_voltage_1") == nullptr || map.find("pack_voltage") != nullptr || map.find("voltage") != nullptr)
    return;
  const auto found = pack_voltage_beside_cells(table, map);
  if (!found) return;
  map.roles["pack_voltage"] = source_of(table, *found);
  map.notes.push_back(
      fmt::format("column recognised by its name: pack_voltage from \"{}\"", table.columns[found->column]));
}

std::optional<StepClock> step_clock(const MeasuredTable& table) {
  const auto found = named(table, kRoleNames.front().tiers[3], Quantity::kTime);
  return found.size() == 1 ? std::optional(StepClock{found[0].column, found[0].unit.scale}) : std::nullopt;
}

RoleMap recognised_map(const MeasuredTable& table) {
  RoleMap map;
  map.source = "column names";
  const auto time = time_column(table);
  auto current = best_named(table, kRoleNames[1]);
  if (!current) current = only(table, "current", worded(table, {"current", "strom", "电流"}, Quantity::kCurrent));
  if (!time || !current) return map;
  map.roles["time"] = source_of(table, *time);
  map.roles["current"] = source_of(table, *current);
  add_voltage(table, map);
  if (!is_enough(map)) return map;
  for (const std::size_t k : {std::size_t{4}, std::size_t{5}}) {
    if (const auto found = best_named(table, kRoleNames[k]))
      map.roles[std::string(kRoleNames[k].role)] = source_of(table, *found);
  }
  for (const Names& tier : kRoleNames[6].tiers) {
    const auto counters = named(table, tier, Quantity::kCharge);
    const auto at = std::find_if(counters.begin(), counters.end(),
                                 [&](const Candidate& c) { return follows_current(table, map, c); });
    if (at == counters.end()) continue;
    map.roles["charge_ah"] = source_of(table, *at);
    break;
  }
  add_counter_pair(table, map);
  note_columns(map);
  VOLTLAP_DEMAND(is_enough(map));
  return map;
}

}  // namespace voltlap::plant
