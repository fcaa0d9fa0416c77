// SPDX-License-Identifier: Apache-2.0
// Tables with a header line, plain or gzipped. Lines that begin with `#` and empty ones are passed over; a byte order
// mark, Windows line ends, blanks and quotation marks around a field are taken as they come.
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

/// What else is known of a column of a measured table.
struct MeasuredColumn {
  std::string unit;                ///< of the row of units below the names, as written; "s" for time stamps
  bool is_stamp = false;           ///< time stamps, brought to seconds
  std::vector<std::string> notes;  ///< how its time stamps were read
  std::string unreadable;          ///< why its numbers cannot be told, with a line; empty when they can

  /// Fields that are no number, by kind.
  struct Holes {
    std::size_t empty = 0, missing = 0, not_finite = 0, words = 0;
    std::string example;  ///< the first that is not empty
    [[nodiscard]] std::size_t all() const { return empty + missing + not_finite + words; }
    /// "3 empty, 1 infinite (such as \"#DIV/0!\")"
    [[nodiscard]] std::string text() const;
  } holes;

  std::vector<std::string> words;          ///< the words that stand in it, up to kMostWords
  std::vector<unsigned char> word_of_row; ///< [row] 1 + index into `words`, 0 for none; may be shorter than the rows
  static constexpr std::size_t kMostWords = 60;
};

/// A table that a test bench or a logger wrote: columns of numbers with holes; an empty field or a word is NaN.
/// Whatever separates its fields, a decimal point or comma, lines of text above the names, a row of units, time stamps
/// and nested levels are found from its rows and said in `notes`.
struct MeasuredTable {
  std::string path;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  ///< [column][row]; finite or NaN
  std::vector<std::size_t> lines;           ///< [row] line in the file, from 1
  std::vector<std::string> repairs;         ///< what was mended while reading, in words
  std::vector<std::string> notes;           ///< how it was read where it is no plain table, in words
  std::vector<MeasuredColumn> about;        ///< [column]; empty for a table that was no file

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  /// Index of a column, or -1.
  [[nodiscard]] int find(std::string_view column) const;
  /// Index of the column that plays a role in a map. Throws InputError when there is none, when two that differ have
  /// that name, and when its numbers cannot be told.
  [[nodiscard]] std::size_t index_for(const std::string& column, const std::string& role,
                                      const std::string& map) const;
};

/// Throws InputError when the file cannot be read, has no rows, or a row in the middle has another number of fields
/// than the header. A last line that was cut off is left out and named in `repairs`.
[[nodiscard]] MeasuredTable read_measured_table(const std::string& path);

}  // namespace voltlap::plant
