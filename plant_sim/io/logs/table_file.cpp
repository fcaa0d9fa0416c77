// SPDX-License-Identifier: Apache-2.0
#include "io/logs/table_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "core/errors.hpp"
#include "io/logs/line_reader.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::string_view trimmed(std::string_view field) {
  const auto first = field.find_first_not_of(" \t\r\"");
  if (first == std::string_view::npos) return {};
  return field.substr(first, field.find_last_not_of(" \t\r\"") - first + 1);
}

double number_of(std::string_view field) {
  const std::string_view digits = trimmed(field);
  double value = kNothing;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc{} && end == digits.data() + digits.size() ? value : kNothing;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t from = 0;;) {
    const std::size_t comma = line.find(',', from);
    fields.push_back(line.substr(from, comma - from));
    if (comma == std::string_view::npos) return fields;
    from = comma + 1;
  }
}

}  // namespace

int MeasuredTable::find(std::string_view column) const {
  const auto at = std::find(columns.begin(), columns.end(), column);
  return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
}

MeasuredTable read_measured_table(const std::string& path) {
  LineReader reader(path);
  MeasuredTable table;
  table.path = path;
  std::string_view line;
  std::size_t cut_off = 0, cut_fields = 0;  // a line that is too short: only the last one may be
  const auto refuse = [&](std::size_t number, std::size_t fields) {
    throw InputError(fmt::format("{}:{}", path, number), fmt::format("{} fields", fields),
                     fmt::format("{} ({})", table.columns.size(), fmt::join(table.columns, ",")),
                     "Complete the row or remove it");
  };
  while (reader.next(line)) {
    if (trimmed(line).empty() || line[0] == '#') continue;
    if (cut_off > 0) refuse(cut_off, cut_fields);
    const auto fields = split(line);
    if (table.columns.empty()) {
      for (const auto field : fields) table.columns.emplace_back(trimmed(field));
      table.values.resize(fields.size());
    } else if (fields.size() < table.columns.size()) {
      cut_off = reader.number();
      cut_fields = fields.size();
    } else if (fields.size() > table.columns.size()) {
      refuse(reader.number(), fields.size());
    } else {
      for (std::size_t k = 0; k < fields.size(); ++k) table.values[k].push_back(number_of(fields[k]));
      table.lines.push_back(reader.number());
    }
  }
  if (cut_off > 0) table.repairs.push_back(fmt::format("last line {} is cut off: left out", cut_off));
  if (table.lines.empty()) {
    throw InputError(path, table.columns.empty() ? "an empty file" : "a header line without rows",
                     "a header line with column names and rows below it",
                     "Check that this is the recording you meant");
  }
  return table;
}

}  // namespace voltlap::plant
