// SPDX-License-Identifier: Apache-2.0
// One field of a measured table as a number: with a decimal point or comma, with or without marks between thousands.
#pragma once
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>

namespace voltlap::plant {

enum class FieldKind {
  kNumber,     ///< a finite number
  kEmpty,      ///< nothing
  kMissing,    ///< what programs write for no value: NaN, NULL, N/A, --, #DIV/0!
  kNotFinite,  ///< an infinity, or a number beyond what a double holds
  kWord,       ///< anything else
};

struct NumberField {
  FieldKind kind = FieldKind::kEmpty;
  double value = 0.0;  ///< of a number
};

/// Without blanks around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// `decimal` is '.' or ','. Marks between thousands (the other of the two, an apostrophe or a narrow blank) are read
/// where each group has three digits. A hexadecimal number, a sign by itself and "1e5x" are words.
[[nodiscard]] NumberField number_field(std::string_view field, char decimal);

/// What a field of digits says of the decimal sign of its table.
enum class DecimalEvidence {
  kNone,           ///< no number, or a whole one
  kPoint,          ///< 3.75, 1,234.5, 1,234,567
  kComma,          ///< 3,75, 1.234,5
  kCommaOrGroups,  ///< 1,234: 1.234 or 1234
  kPointOrGroups,  ///< 1.234
};
[[nodiscard]] DecimalEvidence decimal_evidence(std::string_view field);

/// The quick way for the usual field, a number without marks between thousands: false for all others.
[[nodiscard]] inline bool plain_number(std::string_view field, char decimal, double& value) {
  char copy[48];
  const char *from = field.data(), *to = from + field.size();
  if (decimal == ',') {
    if (field.size() > sizeof(copy)) return false;
    std::size_t commas = 0;
    for (std::size_t k = 0; k < field.size(); ++k) {
      if (field[k] == '.') return false;
      const bool comma = field[k] == ',';
      commas += comma ? 1 : 0;
      copy[k] = comma ? '.' : field[k];
    }
    if (commas > 1) return false;
    from = copy;
    to = copy + field.size();
  }
  if (from != to && *from == '+' && from + 1 != to && from[1] != '-' && from[1] != '+') ++from;
  const auto [end, error] = std::from_chars(from, to, value);
  return error == std::errc{} && end == to && value - value == 0.0;
}

}  // namespace voltlap::plant
