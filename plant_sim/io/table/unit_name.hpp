// SPDX-License-Identifier: Apache-2.0
// Units as the headers of recordings write them: "Current(A)", "I [mA]", "Ecell/V", "Temp (°C)", a row of units.
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace voltlap::plant {

enum class Quantity {
  kTime,
  kCurrent,
  kVoltage,
  kTemperature,
  kCharge,
  kShare,
  kSpeed,
  kRotation,
  kTorque,
  kAcceleration,
  kOther
};

struct NamedUnit {
  std::string_view name;      ///< canonical, such as "mA"
  Quantity quantity = Quantity::kOther;
  double scale = 1.0, offset = 0.0;  ///< SI, degC, Ah: value * scale + offset
};

/// Nothing for a text that is no unit.
[[nodiscard]] std::optional<NamedUnit> unit_named(std::string_view text);
/// A unit, also one of a quantity that no role has, with or without brackets: "[V]", "(Wh)", "km/h".
[[nodiscard]] bool is_unit_text(std::string_view text);

/// A column's name taken apart.
struct ColumnName {
  std::string name;  ///< lower case, without the unit, words separated by single blanks
  std::string unit;  ///< as written; empty when the name has none
};
[[nodiscard]] ColumnName column_name(std::string_view header);

}  // namespace voltlap::plant
