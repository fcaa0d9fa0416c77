// SPDX-License-Identifier: Apache-2.0
// One row for every key of the vehicle and cell files: unit, range, where the value lives, what it is.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Where a key's value lives; the alternative is also its type.
using ParameterAccess = std::variant<double& (*)(VehicleParameters&), int& (*)(VehicleParameters&),
                                     bool& (*)(VehicleParameters&), std::string& (*)(VehicleParameters&),
                                     std::vector<double>& (*)(VehicleParameters&),
                                     std::optional<double>& (*)(VehicleParameters&)>;

/// A quiet key is optional and stands among a car's values only when it is not at its default.
enum class Presence { kRequired, kOptional, kQuiet };

/// What an optional number is while nobody gives it.
struct Followed {
  double (*value)(const VehicleParameters&) = nullptr;
  std::string_view words{};  ///< "5 K below bms.temperature_max_c"
};

struct ParameterRow {
  std::string_view key;   ///< section.field; a cell file's own keys stand in the section `cell`
  std::string_view unit;  ///< "1" for a pure number, "-" for words and switches
  double low, high;       ///< inclusive; for a list, of each of its elements
  Presence presence;
  ParameterAccess access;
  std::string_view description;
  Followed followed{};
};

/// All rows, in the order of the sections. Keys with a number are not among them, see indexed_rows().
[[nodiscard]] std::span<const ParameterRow> parameter_rows();

/// <prefix>.<n>.<field>, n from 1.
struct IndexedRow {
  std::string_view prefix, field;
  std::string_view unit;
  double low, high;
  void (*put)(VehicleParameters&, std::size_t index, double value);
  std::optional<double> (*get)(const VehicleParameters&, std::size_t index);  ///< nothing: not given
  std::string_view description;
};
[[nodiscard]] std::span<const IndexedRow> indexed_rows();

/// How many of a prefix the car has.
[[nodiscard]] std::size_t indexed_count(std::string_view prefix, const VehicleParameters& car);

/// The row of a key, or nullptr.
[[nodiscard]] const ParameterRow* find_parameter(std::string_view key);

/// The key that `key` is the end or the section of (mass_kg, vehicle: vehicle.mass_kg), else the one that needs the
/// fewest edits to become it; keys of single cells included.
[[nodiscard]] std::string nearest_key(std::string_view key);

/// Of some candidates, the one with the smallest edit distance to `word`; empty when none is at most `edits_max` away.
[[nodiscard]] std::string nearest_of(std::string_view word, const std::vector<std::string>& candidates,
                                     std::size_t edits_max);

/// What a value of this row must be, in words: "a number in kg from 20 to 3000".
[[nodiscard]] std::string expectation(const ParameterRow& row);

/// True unless it is a number that nobody gave and that follows another.
[[nodiscard]] bool is_given(const ParameterRow& row, const VehicleParameters& parameters);

/// A number as the car has it, given or followed. The row must be one of a number.
[[nodiscard]] double number_value(const ParameterRow& row, const VehicleParameters& parameters);

/// The value as it would stand in a TOML file; of a number that nobody gave, the one that it follows.
[[nodiscard]] std::string value_text(const ParameterRow& row, const VehicleParameters& parameters);

/// Every key of a car with its value, single cells included: what a result file must carry to be repeated.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> parameter_values(const VehicleParameters& parameters);

}  // namespace voltlap::plant
