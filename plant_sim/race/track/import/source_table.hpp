// SPDX-License-Identifier: Apache-2.0
// A table as loggers, spreadsheets and people write it: separated by commas, semicolons, tabs or blanks, a decimal
// comma where the separator is another, a header line or none, a line of units below it or none. Plain or gzipped.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace voltlap::plant {

class SourceTable {
 public:
  /// Throws InputError when the file cannot be read or has no row.
  explicit SourceTable(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Names of the columns; empty without a header line.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Field of the line of units, else empty.
  [[nodiscard]] const std::string& unit(std::size_t column) const;
  [[nodiscard]] char separator() const { return separator_; }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  /// Empty where the row is short.
  [[nodiscard]] const std::string& text(std::size_t row, std::size_t column) const;
  /// Throws InputError with file and line when the field is no finite number.
  [[nodiscard]] double number(std::size_t row, std::size_t column) const;
  /// "file:line" of a row.
  [[nodiscard]] std::string place(std::size_t row) const;

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> fields;
  };
  void find_separator(const std::vector<std::string>& lines);
  [[nodiscard]] std::vector<std::string> split(const std::string& line) const;
  [[nodiscard]] std::optional<double> parsed(std::string field) const;
  [[nodiscard]] bool has_number(const std::vector<std::string>& fields) const;

  std::string path_;
  char separator_ = ',';
  std::vector<std::string> names_, units_;
  std::vector<Row> rows_;
  std::size_t columns_ = 0;
};

}  // namespace voltlap::plant
