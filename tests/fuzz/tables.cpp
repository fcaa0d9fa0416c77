// SPDX-License-Identifier: Apache-2.0
#include "core/demand.hpp"
#include "fuzz/target.hpp"
#include "io/line_reader.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {
namespace {

std::size_t bytes_of_lines(const std::string& path, BrokenStream broken) {
  LineReader reader(path, "a text", broken);
  std::string_view line;
  std::size_t bytes = 0, lines = 0;
  while (reader.next(line)) {
    VOLTLAP_DEMAND(line.find_first_of("\r\n") == std::string_view::npos);
    VOLTLAP_DEMAND(reader.number() == ++lines);
    bytes += line.size();
  }
  return bytes;
}

}  // namespace

void read_lines(const std::string& path) {
  const std::size_t kept = bytes_of_lines(path, BrokenStream::kKeep);
  VOLTLAP_DEMAND(bytes_of_lines(path, BrokenStream::kRefuse) == kept);
}

void read_measured(const std::string& path) {
  const MeasuredTable table = read_measured_table(path);
  VOLTLAP_DEMAND(table.rows() > 0 && table.values.size() == table.columns.size());
  for (const auto& column : table.values) VOLTLAP_DEMAND(column.size() == table.rows());
  for (std::size_t k = 1; k < table.rows(); ++k) VOLTLAP_DEMAND(table.lines[k] > table.lines[k - 1]);
  for (const std::string& name : table.columns) VOLTLAP_DEMAND(table.find(name) >= 0);
}

void read_input_table(const std::string& path) {
  const InputTable table(path);
  VOLTLAP_DEMAND(table.rows() > 0 && !table.columns().empty());
  for (const std::string& column : table.columns()) {
    VOLTLAP_DEMAND(table.has(column));
    for (std::size_t row = 0; row < table.rows(); ++row) {
      VOLTLAP_DEMAND(!table.place(row).empty() && table.text(row, column).find('\n') == std::string::npos);
    }
  }
  for (const std::string& column : table.columns()) {
    for (std::size_t row = 0; row < table.rows(); ++row) VOLTLAP_DEMAND(std::isfinite(table.number(row, column)));
  }
}

}  // namespace voltlap::plant
