// SPDX-License-Identifier: Apache-2.0
// Comma-separated tables with a header line, plain or gzipped. Lines that begin with `#` and empty ones are passed
// over; a byte order mark, Windows line ends, blanks and quotation marks around a field are taken as they come.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

/// A table that somebody wrote for the program (track, drive, reference runs): words and numbers, none missing.
class InputTable {
 public:
  /// Throws InputError when the file cannot be read, has no rows, or a row has another number of fields than the
  /// header.
  explicit InputTable(const std::string& path);

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] bool has(std::string_view column) const;
  /// Field as text. Throws InputError that lists the columns there are when `column` is missing.
  [[nodiscard]] const std::string& text(std::size_t row, std::string_view column) const;
  /// Field as a finite number; throws InputError with file and line otherwise.
  [[nodiscard]] double number(std::size_t row, std::string_view column) const;
  /// "file:line" of a row, for messages.
  [[nodiscard]] std::string place(std::size_t row) const;
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> fields;
  };
  [[nodiscard]] std::size_t index(std::string_view column) const;

  std::string path_;
  std::vector<std::string> columns_;
  std::size_t header_line_ = 0;
  std::vector<Row> rows_;
};

/// A table that a test bench or a logger wrote: columns of numbers with holes; an empty field or a word is NaN.
struct MeasuredTable {
  std::string path;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  ///< [column][row]
  std::vector<std::size_t> lines;           ///< [row] line in the file, from 1
  std::vector<std::string> repairs;         ///< what was mended while reading, in words

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  /// Index of a column, or -1.
  [[nodiscard]] int find(std::string_view column) const;
};

/// Throws InputError when the file cannot be read, has no rows, or a row in the middle has another number of fields
/// than the header. A last line that was cut off is left out and named in `repairs`.
[[nodiscard]] MeasuredTable read_measured_table(const std::string& path);

}  // namespace voltlap::plant
