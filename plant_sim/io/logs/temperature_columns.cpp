// SPDX-License-Identifier: Apache-2.0
#include "io/logs/temperature_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/signal.hpp"
#include "io/logs/plain_columns.hpp"

namespace voltlap::plant {
namespace {

// Parts of a word that mean a temperature; "temp" is one only where the word ends: "temps" and "tempo" are times.
constexpr std::array<std::string_view, 4> kTemperature{"temperat", "températ", "thermo", "温度"};
// Begins of words about the air around a cell, and about what is no cell.
constexpr std::array<std::string_view, 18> kAir{"chamber", "amb",    "umgebung", "kammer", "klima", "chambre",
                                                "enceinte", "camara", "cámara",  "oven",   "ofen",  "air",
                                                "luft",     "room",   "raum",    "environ", "tamb",  "环境"};
constexpr std::array<std::string_view, 17> kOther{"motor",  "inverter", "igbt",    "board",   "pcb",  "bms",
                                                  "cpu",    "heatsink", "coolant", "water",   "charger", "set",
                                                  "target", "limit",    "soll",    "consigne", "tester"};
// Letters that stand for a thermocouple or a thermistor where a number follows.
constexpr std::array<std::string_view, 5> kNumbered{"t", "tc", "tu", "ntc", "tk"};
constexpr double kColdest_c = -60.0, kHottest_c = 150.0;  // of a cell's test

struct Found {
  std::size_t column;
  NamedUnit unit;
  std::string name;  ///< in lower case
  bool is_plausible;  ///< for a cell's test
};

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> out(1);
  for (const char c : name) {
    if (c == ' ' || c == '(' || c == ')' || c == '.' || c == '/') {
      if (!out.back().empty()) out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  if (out.back().empty()) out.pop_back();
  return out;
}

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

template <class Begins>
bool says_one_of(const std::string& name, const Begins& begins) {
  const std::vector<std::string> words = words_of(name);
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::any_of(begins.begin(), begins.end(), [&](std::string_view begin) { return word.starts_with(begin); });
  });
}

/// "temperature", "cell temp", "temp3", "tc1", "tu 2".
bool means_a_temperature(const std::string& name) {
  const auto has = [&](std::string_view part) { return name.find(part) != std::string::npos; };
  if (std::any_of(kTemperature.begin(), kTemperature.end(), has)) return true;
  const std::vector<std::string> words = words_of(name);
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string letters = words[k].substr(0, words[k].find_first_of("0123456789"));
    if (letters.ends_with("temp") || letters == "tcell" || letters == "tzelle") return true;
    const std::string next = k + 1 < words.size() ? words[k + 1] : "";
    if (letters == "t" && (next.starts_with("cell") || next.starts_with("zell"))) return true;
    const bool number = is_number(std::string_view(words[k]).substr(letters.size())) ||
                        (letters == words[k] && is_number(next));
    if (number && std::find(kNumbered.begin(), kNumbered.end(), letters) != kNumbered.end()) return true;
  }
  return false;
}

std::optional<Found> temperature_in(const MeasuredTable& table, std::size_t column) {
  const ColumnName label = column_name(table.columns[column]);
  auto unit = file_unit(table, column);
  if (!unit) unit = unit_named(label.unit);
  if (unit && unit->quantity != Quantity::kTemperature) return std::nullopt;
  std::string name = label.name, behind = label.unit;
  std::transform(behind.begin(), behind.end(), behind.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool says_where = !unit && says_one_of(behind, kAir);  // "Temperature(Chamber)"
  if (says_where) name += " " + behind;
  // A unit that nobody knows is of something else: "Chamber pressure (bar)".
  if (!unit && ((!behind.empty() && !says_where) || !means_a_temperature(name))) return std::nullopt;
  const NamedUnit told = unit.value_or(NamedUnit{"", Quantity::kTemperature});
  std::vector<double> values = table.values[column];
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::nullopt;
  double middle_c = median(std::move(values)) * told.scale + told.offset;
  constexpr double kKelvin = 273.15;
  if (!unit && middle_c > kHottest_c) middle_c -= kKelvin;  // the reader brings it to degC
  return Found{column, told, name, middle_c > kColdest_c && middle_c < kHottest_c};
}

bool is_taken(const MeasuredTable& table, const RoleMap& map, std::size_t column) {
  return std::any_of(map.roles.begin(), map.roles.end(),
                     [&](const auto& entry) { return entry.second.column == table.columns[column]; });
}

}  // namespace

void add_temperatures(const MeasuredTable& table, RoleMap& map) {
  std::vector<std::string> taken, left;
  const auto take = [&](const Found& found, const char* role, const char* whose) {
    map.roles[role] = {table.columns[found.column], found.unit.scale, found.unit.offset, DischargeSign::kAuto,
                       std::string(found.unit.name)};
    taken.push_back(fmt::format("{} from \"{}\"{}", whose, table.columns[found.column],
                                found.unit.name.empty() ? ", no unit given" : fmt::format(" in {}", found.unit.name)));
  };
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (is_taken(table, map, k)) continue;
    const auto found = temperature_in(table, k);
    if (!found) continue;
    const bool other = says_one_of(found->name, kOther), air = says_one_of(found->name, kAir);
    const bool usable = found->is_plausible && !other;
    if (usable && !air && map.find("temperature_1") == nullptr) {
      take(*found, "temperature_1", "the cell's");
    } else if (usable && air && map.find("ambient") == nullptr) {
      take(*found, "ambient", "the air's");
    } else {
      left.push_back(fmt::format("\"{}\"", table.columns[k]));
    }
  }
  if (!taken.empty())
    map.notes.push_back(fmt::format("temperature recognised by its name or unit: {}", fmt::join(taken, "; ")));
  if (!left.empty())
    map.notes.push_back(fmt::format("temperatures that are not used: {}; a map (--map) can name one as temperature_1, "
                                    "or as ambient",
                                    fmt::join(left, ", ")));
}

}  // namespace voltlap::plant
