// SPDX-License-Identifier: Apache-2.0
#include "io/table_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/line_reader.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets put it before UTF-8
constexpr const char* kRowsExpected = "a header line with column names and at least one row below it";

std::string_view trimmed(std::string_view field) {
  const auto first = field.find_first_not_of(" \t\r\"");
  if (first == std::string_view::npos) return {};
  return field.substr(first, field.find_last_not_of(" \t\r\"") - first + 1);
}

/// NaN for an empty field and for a word.
double number_of(std::string_view field) {
  double value = kNothing;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc{} && end == field.data() + field.size() ? value : kNothing;
}

/// The one place that knows what a table looks like: header first, then row by row.
class RowReader {
 public:
  RowReader(const std::string& path, const char* expected) : lines_(path, expected) {
    if (!next()) return;
    columns_.assign(fields_.begin(), fields_.end());
    header_line_ = line();
  }

  /// Fields of the next row, valid until the next call; false at the end of the file.
  bool next() {
    std::string_view text;
    while (lines_.next(text)) {
      if (lines_.number() == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
      if (trimmed(text).empty() || text[0] == '#') continue;
      split(text);
      return true;
    }
    return false;
  }

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }  ///< none in an empty file
  [[nodiscard]] std::size_t header_line() const { return header_line_; }
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  [[nodiscard]] std::size_t line() const { return lines_.number(); }

  [[noreturn]] void refuse(std::size_t line, std::size_t fields, const char* what_to_do) const {
    throw InputError(fmt::format("{}:{}", lines_.path(), line), fmt::format("{} fields", fields),
                     fmt::format("{} ({})", columns_.size(), fmt::join(columns_, ",")), what_to_do);
  }

 private:
  void split(std::string_view text) {
    fields_.clear();
    for (std::size_t from = 0;;) {
      const std::size_t comma = text.find(',', from);
      fields_.push_back(trimmed(text.substr(from, comma - from)));
      if (comma == std::string_view::npos) return;
      from = comma + 1;
    }
  }

  LineReader lines_;
  std::vector<std::string> columns_;
  std::size_t header_line_ = 0;
  std::vector<std::string_view> fields_;
};

}  // namespace

InputTable::InputTable(const std::string& path) : path_(path) {
  RowReader reader(path, "a CSV file");
  columns_ = reader.columns();
  header_line_ = reader.header_line();
  while (reader.next()) {
    const auto& fields = reader.fields();
    if (fields.size() != columns_.size()) {
      reader.refuse(reader.line(), fields.size(), "Give the row a field for each column, separated by commas");
    }
    rows_.push_back({reader.line(), {fields.begin(), fields.end()}});
  }
  if (rows_.empty()) {
    throw InputError(path, columns_.empty() ? "an empty file" : "a header line and no row", kRowsExpected,
                     "Fill the file in");
  }
}

bool InputTable::has(std::string_view column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

std::size_t InputTable::index(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) {
    throw InputError(fmt::format("{}:{}", path_, header_line_), fmt::format("the columns {}", fmt::join(columns_, ",")),
                     fmt::format("a column {}", column),
                     "Add the column, or correct its name in the header line; commas separate columns");
  }
  return static_cast<std::size_t>(found - columns_.begin());
}

const std::string& InputTable::text(std::size_t row, std::string_view column) const {
  VOLTLAP_DEMAND(row < rows_.size());
  return rows_[row].fields[index(column)];
}

double InputTable::number(std::size_t row, std::string_view column) const {
  const std::string& field = text(row, column);
  const double value = number_of(field);
  if (!std::isfinite(value)) {
    throw InputError(fmt::format("{}, {}", place(row), column), fmt::format("\"{}\"", field),
                     "a finite number, with a decimal point where it has a fraction", "Correct the field");
  }
  return value;
}

std::string InputTable::place(std::size_t row) const {
  VOLTLAP_DEMAND(row < rows_.size());
  return fmt::format("{}:{}", path_, rows_[row].line);
}

}  // namespace voltlap::plant
