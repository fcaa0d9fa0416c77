// SPDX-License-Identifier: Apache-2.0
#include "core/csv.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets put it before UTF-8

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back().push_back(c);
    }
  }
  for (auto& field : fields) {
    const auto first = field.find_first_not_of(" \t");
    const auto last = field.find_last_not_of(" \t");
    field = first == std::string::npos ? "" : field.substr(first, last - first + 1);
  }
  return fields;
}

}  // namespace

CsvTable::CsvTable(const std::string& path) : path_(path) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  std::ifstream in(path);
  if (!in || folder) {
    throw InputError(path, folder ? "a folder" : std::string("no file that can be opened: ") + std::strerror(errno),
                     "a CSV file", "Check the path and that you may read it");
  }
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    auto fields = split(line);
    if (columns_.empty()) {
      columns_ = std::move(fields);
      header_line_ = number;
    } else if (fields.size() != columns_.size()) {
      throw InputError(fmt::format("{}:{}", path, number), fmt::format("{} fields", fields.size()),
                       fmt::format("{} ({})", columns_.size(), fmt::join(columns_, ",")),
                       "Give the row a field for each column, separated by commas");
    } else {
      rows_.push_back({number, std::move(fields)});
    }
  }
  if (columns_.empty() || rows_.empty()) {
    throw InputError(path, columns_.empty() ? "an empty file" : "a header line and no row",
                     "a header line with column names and at least one row below it", "Fill the file in");
  }
}

bool CsvTable::has(const std::string& column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

std::size_t CsvTable::index(const std::string& column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) {
    throw InputError(fmt::format("{}:{}", path_, header_line_), fmt::format("the columns {}", fmt::join(columns_, ",")),
                     fmt::format("a column {}", column),
                     "Add the column, or correct its name in the header line; commas separate columns");
  }
  return static_cast<std::size_t>(found - columns_.begin());
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  return rows_[row].fields[index(column)];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& field = text(row, column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value)) {
    throw InputError(fmt::format("{}, {}", place(row), column), fmt::format("\"{}\"", field),
                     "a finite number, with a decimal point where it has a fraction", "Correct the field");
  }
  return value;
}

std::string CsvTable::place(std::size_t row) const { return fmt::format("{}:{}", path_, rows_[row].line); }

}  // namespace voltlap::plant
