// SPDX-License-Identifier: Apache-2.0
// How a table is written: what separates its fields, its decimal sign, where its names, units and rows are. Found from
// many rows together, since a single line such as 0,5;1,5 can be read in several ways.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

/// A row of text with the line in the file at which it begins.
struct TableLine {
  std::string text;
  std::size_t number = 0;
};

struct TableDialect {
  char separator = ',';               ///< ' ': runs of blanks
  char decimal = '.';
  bool decimal_open = false;          ///< no row that was looked at has a fraction
  std::vector<std::string> columns;   ///< names, UTF-8; "column 3" where there is none
  std::vector<std::string> units;     ///< of the row below the names, "" where there is none
  std::vector<bool> is_stamp;         ///< [column] time stamps rather than numbers
  std::size_t leading_empty = 0;      ///< fields that are empty in a row of the innermost level of a nested table
  std::size_t header_line = 0;        ///< 0: no content at all
  std::size_t first_row = 0;          ///< index of the first row among the lines that were looked at
  std::vector<std::string> notes;     ///< what is not as in a plain table, in words
};

/// A line that is blank or a comment (#, %, ~, //).
[[nodiscard]] bool is_passed_over(std::string_view text);

/// Throws InputError for rows of numbers without a line of names.
[[nodiscard]] TableDialect dialect_of(const std::string& path, const std::vector<TableLine>& lines);

}  // namespace voltlap::plant
