// SPDX-License-Identifier: Apache-2.0
// A small strict reader of comma-separated numbers and words: every complaint names file and line.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace voltlap::plant {

/// A table with a header line. `#` begins a comment line. Rows have exactly as many fields as the header. A byte order
/// mark and Windows line ends are taken as they come.
class CsvTable {
 public:
  /// Throws InputError when the file cannot be read, is empty, or a row has another number of fields than the header.
  explicit CsvTable(const std::string& path);

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] bool has(const std::string& column) const;
  /// Field as text. Throws InputError that lists the columns there are when `column` is missing.
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  /// Field as a finite number; throws InputError with file and line otherwise.
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  /// "file:line" of a row, for messages.
  [[nodiscard]] std::string place(std::size_t row) const;
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> fields;
  };
  [[nodiscard]] std::size_t index(const std::string& column) const;

  std::string path_;
  std::vector<std::string> columns_;
  std::size_t header_line_ = 0;
  std::vector<Row> rows_;
};

}  // namespace voltlap::plant
