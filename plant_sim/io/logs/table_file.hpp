// SPDX-License-Identifier: Apache-2.0
// Measured tables: comma-separated numbers with a header line, plain or gzipped, as test benches and loggers write
// them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

/// Columns of numbers. Unlike a project's own CSV a measured table may have holes: an empty field or a word is NaN.
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
