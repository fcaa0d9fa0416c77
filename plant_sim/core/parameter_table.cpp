// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/demand.hpp"
#include "core/parameter_rows.hpp"

namespace voltlap::plant {
namespace {

/// Levenshtein distance: fewest insertions, removals and replacements of a letter.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string list_text(const std::vector<double>& values) { return fmt::format("[{}]", fmt::join(values, ", ")); }

template <class Value>
std::string toml_text(const Value& value) {
  if constexpr (std::is_same_v<Value, std::string>) return '"' + value + '"';
  else if constexpr (std::is_same_v<Value, std::vector<double>>) return list_text(value);
  else return fmt::format("{}", value);
}

std::vector<ParameterRow> joined(std::initializer_list<std::span<const ParameterRow>> parts) {
  std::vector<ParameterRow> out;
  for (const auto part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

}  // namespace

std::span<const ParameterRow> parameter_rows() {
  static const std::vector<ParameterRow> all =
      joined({car_parameter_rows(), cell_parameter_rows(), instrument_parameter_rows(), firmware_parameter_rows()});
  return all;
}

std::span<const IndexedRow> indexed_rows() {
  static const std::vector<IndexedRow> all = [] {
    std::vector<IndexedRow> out;
    for (const auto part : {cell_variation_rows(), instrument_channel_rows()})
      out.insert(out.end(), part.begin(), part.end());
    return out;
  }();
  return all;
}

std::size_t indexed_count(std::string_view prefix, const VehicleParameters& car) {
  return static_cast<std::size_t>(prefix == "sensors.thermistors" ? car.sensors.temperature_count
                                                                  : car.battery.cells_in_series);
}

const ParameterRow* find_parameter(std::string_view key) {
  const auto rows = parameter_rows();
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const ParameterRow& row) { return row.key == key; });
  return found == rows.end() ? nullptr : &*found;
}

std::string nearest_of(std::string_view word, const std::vector<std::string>& candidates, std::size_t edits_max) {
  std::string best;
  std::size_t least = edits_max;
  for (const std::string& candidate : candidates) {
    const std::size_t edits = edit_distance(word, candidate);
    if (edits > least || (edits == least && !best.empty())) continue;
    best = candidate;
    least = edits;
  }
  return best;
}

std::string nearest_key(std::string_view key) {
  std::vector<std::string> candidates;
  for (const ParameterRow& row : parameter_rows()) candidates.emplace_back(row.key);
  for (const IndexedRow& row : indexed_rows()) {
    candidates.push_back(fmt::format("{}.<n>.{}", row.prefix, row.field));
  }
  for (const std::string& candidate : candidates) {
    if (candidate.ends_with("." + std::string(key)) || candidate.starts_with(std::string(key) + ".")) return candidate;
  }
  constexpr std::size_t kAnyDistance = 1000;
  return nearest_of(key, candidates, kAnyDistance);
}

std::string expectation(const ParameterRow& row) {
  const std::string range = row.unit == "1" ? fmt::format("from {} to {}", row.low, row.high)
                                            : fmt::format("in {} from {} to {}", row.unit, row.low, row.high);
  constexpr std::size_t kInt = 1, kBool = 2, kString = 3, kList = 4;
  switch (row.access.index()) {
    case kInt: return "a whole number " + range;
    case kBool: return "true or false";
    case kString: return fmt::format("a word in quotes ({})", row.description);
    case kList: return fmt::format("a list of numbers {}", range);
    default: return "a number " + range;
  }
}

double number_value(const ParameterRow& row, const VehicleParameters& parameters) {
  // The accessors hand out references to change; here one is only read.
  auto& car = const_cast<VehicleParameters&>(parameters);
  return std::visit(
      [&](auto access) {
        using Value = std::remove_cvref_t<decltype(access(car))>;
        if constexpr (std::is_same_v<Value, std::optional<double>>) {
          VOLTLAP_DEMAND(row.followed.value != nullptr);
          return access(car) ? *access(car) : row.followed.value(parameters);
        } else if constexpr (std::is_arithmetic_v<Value>) {
          return static_cast<double>(access(car));
        } else {
          VOLTLAP_DEMAND(!"a row of a number");
          return 0.0;
        }
      },
      row.access);
}

bool is_given(const ParameterRow& row, const VehicleParameters& parameters) {
  const auto* optional = std::get_if<std::optional<double>& (*)(VehicleParameters&)>(&row.access);
  return optional == nullptr || (*optional)(const_cast<VehicleParameters&>(parameters)).has_value();
}

std::string value_text(const ParameterRow& row, const VehicleParameters& parameters) {
  auto& car = const_cast<VehicleParameters&>(parameters);
  return std::visit(
      [&](auto access) {
        if constexpr (std::is_same_v<decltype(access(car)), std::optional<double>&>) {
          return toml_text(number_value(row, parameters));
        } else {
          return toml_text(access(car));
        }
      },
      row.access);
}

static std::size_t most_channels(const VehicleParameters& car) {
  return std::max({car.battery.cells.size(), car.sensors.cells.size(), car.sensors.thermistors.size()});
}

std::vector<std::pair<std::string, std::string>> parameter_values(const VehicleParameters& parameters) {
  VOLTLAP_DEMAND(!parameter_rows().empty());
  std::vector<std::pair<std::string, std::string>> out;
  const VehicleParameters defaults;
  for (const ParameterRow& row : parameter_rows()) {
    std::string value = value_text(row, parameters);
    if (row.presence == Presence::kQuiet && value == value_text(row, defaults)) continue;
    out.emplace_back(row.key, std::move(value));
  }
  for (std::size_t n = 0; n < most_channels(parameters); ++n) {
    for (const IndexedRow& row : indexed_rows()) {
      if (const auto value = row.get(parameters, n)) {
        out.emplace_back(fmt::format("{}.{}.{}", row.prefix, n + 1, row.field), toml_text(*value));
      }
    }
  }
  return out;
}

}  // namespace voltlap::plant
