// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plain_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/map_proposal.hpp"

namespace voltlap::plant {
namespace {

Quantity quantity_of_role(std::string_view role) {
  constexpr std::array kStems{std::pair{"time", Quantity::kTime},         std::pair{"current", Quantity::kCurrent},
                              std::pair{"voltage", Quantity::kVoltage},   std::pair{"pack_voltage", Quantity::kVoltage},
                              std::pair{"bus_voltage", Quantity::kVoltage},
                              std::pair{"cell_voltage", Quantity::kVoltage},
                              std::pair{"temperature", Quantity::kTemperature},
                              std::pair{"ambient", Quantity::kTemperature}, std::pair{"charge", Quantity::kCharge},
                              std::pair{"discharged", Quantity::kCharge}};
  for (const auto& [stem, quantity] : kStems) {
    if (role.starts_with(stem)) return quantity;
  }
  return Quantity::kOther;
}

/// Same numbers row by row, after their units.
bool agree(const MeasuredTable& table, const RoleSource& a, const RoleSource& b) {
  const auto& first = table.values[static_cast<std::size_t>(table.find(a.column))];
  const auto& second = table.values[static_cast<std::size_t>(table.find(b.column))];
  constexpr double kSame = 1e-3;  // relative: one may be rounded
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double x = first[row] * a.scale + a.offset, y = second[row] * b.scale + b.offset;
    if (std::isnan(x) && std::isnan(y)) continue;
    if (!(std::abs(x - y) <= kSame * std::max(std::abs(x), std::abs(y)))) return false;
  }
  return true;
}

/// "[0.1A]", "(10 mV)", "[daV]": what looks like a unit and is none that is known would be off by its scale.
void refuse_unknown_unit(const MeasuredTable& table, std::size_t column, const std::string& role) {
  const std::string row = table.about.empty() ? "" : table.about[column].unit;
  const std::string text = row.empty() ? column_name(table.columns[column]).unit : row;
  const bool is_stamp = !table.about.empty() && table.about[column].is_stamp;
  if (text.empty() || is_stamp || is_unit_text(text)) return;
  const bool has_digit = std::any_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
  const bool like_unit = text.size() <= 4 && (text.ends_with('A') || text.ends_with('V') || text.ends_with('s'));
  if (!has_digit && !like_unit) return;
  throw InputError(fmt::format("{}, column \"{}\"", table.path, table.columns[column]),
                   fmt::format("the unit \"{}\"", text), fmt::format("a unit that is known for the role {}", role),
                   "Give unit and scale in a map (--map)");
}

}  // namespace

std::optional<NamedUnit> file_unit(const MeasuredTable& table, std::size_t column) {
  VOLTLAP_DEMAND(column < table.columns.size());
  if (!table.about.empty()) {
    if (const auto unit = unit_named(table.about[column].unit)) return unit;
  }
  const std::string& header = table.columns[column];
  const ColumnName name = column_name(header);
  // A name such as i_a or temp_c ends in a letter of its own; only a map's word or a row of units makes it a unit.
  const bool letter = name.unit.size() == 1 && header.ends_with("_" + name.unit);
  return letter ? std::nullopt : unit_named(name.unit);
}

RoleSource with_file_unit(const RoleSource& source, const std::string& role, const MeasuredTable& table,
                          const std::string& map, std::vector<std::string>& notes) {
  const int index = table.find(source.column);
  const Quantity quantity = quantity_of_role(role);
  RoleSource out = source;
  if (source.unit.empty() && (source.scale != 1.0 || source.offset != 0.0)) out.unit = "SI";  // the map's own scale
  if (index < 0 || quantity == Quantity::kOther) return out;
  const auto unit = file_unit(table, static_cast<std::size_t>(index));
  if (!unit) {
    if (source.unit.empty()) refuse_unknown_unit(table, static_cast<std::size_t>(index), role);
    return out;
  }
  const auto refuse = [&](const std::string& found) {
    throw InputError(fmt::format("{}, column \"{}\"", table.path, source.column), found,
                     fmt::format("the same unit for the role {} in the file and in {}", role, map),
                     "Correct the unit in the map, or leave it out there");
  };
  if (unit->quantity != quantity) {
    if (quantity == Quantity::kTime || quantity == Quantity::kCurrent || quantity == Quantity::kVoltage)
      refuse(fmt::format("the unit {}", unit->name));
    return out;
  }
  if (out.unit == "SI") return out;
  if (source.unit.empty() || source.unit == "1") {
    out.unit = unit->name;
    out.scale = unit->scale;
    out.offset = unit->offset;
    if (unit->scale != 1.0 || unit->offset != 0.0)
      notes.push_back(fmt::format("\"{}\" is in {}, as the file says", source.column, unit->name));
    return out;
  }
  const auto named = unit_named(source.unit);
  const bool own_scale = named && (source.scale != named->scale || source.offset != named->offset);
  if (!named || own_scale || (named->scale == unit->scale && named->offset == unit->offset)) return source;
  refuse(fmt::format("{} in the file and {} in the map", unit->name, source.unit));
  return out;
}

bool is_enough(const RoleMap& map) {
  return map.find("time") != nullptr && map.find("current") != nullptr &&
         (map.find("voltage") != nullptr || map.find("pack_voltage") != nullptr ||
          map.find("cell_voltage_1") != nullptr);
}

RoleMap plain_map(const MeasuredTable& table) {
  struct Suffix {
    std::string_view text, unit;
  };
  constexpr std::array kSuffixes{
      Suffix{"_s", "s"},   Suffix{"_ms", "ms"},  Suffix{"_a", "A"},     Suffix{"_ma", "mA"},   Suffix{"_v", "V"},
      Suffix{"_mv", "mV"}, Suffix{"_c", "degC"}, Suffix{"_mps", "m/s"}, Suffix{"_rpm", "rpm"}, Suffix{"_nm", "Nm"}};
  RoleMap map;
  map.source = "column names";
  std::vector<std::pair<std::string, RoleSource>> others;  // of roles that a column has already
  const auto add = [&](const std::string& role, const std::string& column, std::string_view unit_name) {
    if (!is_role(role)) return;
    const Unit unit = unit_of(table.path, std::string(unit_name));
    const RoleSource source{column, unit.scale, unit.offset, DischargeSign::kAuto,
                            unit_name == "1" ? "" : std::string(unit_name)};
    if (!map.roles.try_emplace(role, source).second) others.emplace_back(role, source);
  };
  for (const std::string& column : table.columns) {
    if (is_role(column)) add(column, column, "1");
    for (const Suffix& suffix : kSuffixes) {
      if (!column.ends_with(suffix.text)) continue;
      std::string role = column.substr(0, column.size() - suffix.text.size());
      if (role == "pack_current") role = "current";
      if (role == "temperature") role = "temperature_1";
      add(role, column, suffix.unit);
    }
  }
  if (!is_enough(map)) return map;
  for (const auto& [role, source] : others) {
    const RoleSource& taken = map.roles.at(role);
    if (taken.column == source.column || agree(table, taken, source)) continue;
    throw InputError(table.path, fmt::format("\"{}\" and \"{}\" for the role {}", taken.column, source.column, role),
                     "one column for each role",
                     fmt::format("Say which in a map (--map): {} = {{column = \"{}\", unit = \"{}\"}}", role,
                                 taken.column, taken.unit));
  }
  return map;
}

std::optional<std::string> sign_by_state(const MeasuredTable& table, std::vector<double>& current) {
  if (std::any_of(current.begin(), current.end(), [](double i) { return i < 0.0; })) return std::nullopt;
  const auto has = [](const std::string& text, std::initializer_list<std::string_view> parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](std::string_view part) { return text.find(part) != std::string::npos; });
  };
  enum class State { kOther, kCharge, kDischarge };
  const auto state_of = [&](std::string word) {
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    if (word == "d" || has(word, {"dchg", "dch", "dis", "entl", "ent", "\xE6\x94\xBE\xE7\x94\xB5"}))
      return State::kDischarge;
    if (word == "c" || has(word, {"chg", "cha", "lad", "\xE5\x85\x85\xE7\x94\xB5"})) return State::kCharge;
    return State::kOther;
  };
  for (std::size_t k = 0; k < table.about.size(); ++k) {
    const MeasuredColumn& about = table.about[k];
    std::vector<State> states;
    for (const std::string& word : about.words) states.push_back(state_of(word));
    const bool tells = std::count(states.begin(), states.end(), State::kCharge) > 0 &&
                       std::count(states.begin(), states.end(), State::kDischarge) > 0;
    if (!tells) continue;
    std::size_t turned = 0;
    for (std::size_t row = 0; row < std::min(current.size(), about.word_of_row.size()); ++row) {
      const unsigned char word = about.word_of_row[row];
      if (word == 0 || states[word - 1U] != State::kCharge || current[row] == 0.0) continue;
      current[row] = -current[row];
      ++turned;
    }
    return fmt::format("the current has no sign: {} rows are a charge by \"{}\"", turned, table.columns[k]);
  }
  return std::nullopt;
}

namespace {

/// Columns in which no field is a number, with an example: "4.2 V" is none.
std::string columns_of_words(const MeasuredTable& table) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < table.about.size(); ++k) {
    if (table.about[k].holes.words == table.rows())
      parts.push_back(fmt::format("\"{}\" (\"{}\")", table.columns[k], table.about[k].holes.example));
  }
  return parts.empty() ? "" : fmt::format("; no numbers in {}", fmt::join(parts, ", "));
}

}  // namespace

RoleMap role_map_for(const MeasuredTable& table, const DataFolder& data) {
  RoleMap plain = plain_map(table);
  if (is_enough(plain)) return plain;
  const std::string header = fmt::format("{}", fmt::join(table.columns, ","));
  for (const std::string& name : data.names("maps")) {
    RoleMap map = load_role_map(data.find("maps", name, "maps"));
    if (std::find(map.match.begin(), map.match.end(), header) != map.match.end()) return map;
  }
  std::string two_for_one_role;
  try {
    RoleMap recognised = recognised_map(table);
    if (is_enough(recognised)) return recognised;
  } catch (const InputError& error) {
    two_for_one_role = error.what();  // behaviour may tell them apart
  }
  const MapProposal proposal = propose_map(signals_of(table));
  if (proposal.is_complete()) return proposal.map();
  if (!two_for_one_role.empty()) {
    throw InputError(fmt::format("{} This draft is a map but for what stands open in it (--write-map writes it):\n{}",
                                 two_for_one_role, proposal.draft()));
  }
  throw InputError(table.path, fmt::format("columns {}{}", fmt::join(table.columns, ", "), columns_of_words(table)),
                   "time_s, current_a and voltage_v, or a role map (--map)",
                   "This draft is a map but for what stands open in it; save it (--write-map FILE does), choose, and "
                   "give it with --map:\n" + proposal.draft());
}

}  // namespace voltlap::plant
