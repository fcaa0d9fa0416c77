// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/source_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/line_reader.hpp"

namespace voltlap::plant {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
const std::string kNothing;

std::string trimmed(std::string_view field) {
  const auto first = field.find_first_not_of(" \t\r\"");
  if (first == std::string_view::npos) return {};
  return std::string(field.substr(first, field.find_last_not_of(" \t\r\"") - first + 1));
}

}  // namespace

SourceTable::SourceTable(const std::string& path) : path_(path) {
  LineReader reader(path, "a table of points, gates, curvature or segments, or a GPX file");
  std::vector<std::string> lines;
  std::vector<std::size_t> numbers;
  std::string_view text;
  while (reader.next(text)) {
    if (reader.number() == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    const std::string line = trimmed(text);
    if (line.empty() || line[0] == '#' || line[0] == '%') continue;
    lines.emplace_back(text);
    numbers.push_back(reader.number());
  }
  find_separator(lines);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<std::string> fields = split(lines[i]);
    const bool words = std::any_of(fields.begin(), fields.end(), [](const std::string& f) { return !f.empty(); });
    if (words && !has_number(fields) && rows_.empty() && (names_.empty() || units_.empty())) {
      (names_.empty() ? names_ : units_) = std::move(fields);
      continue;
    }
    columns_ = std::max(columns_, fields.size());
    rows_.push_back({numbers[i], std::move(fields)});
  }
  columns_ = std::max(columns_, names_.size());
  while (!names_.empty() && names_.back().empty()) names_.pop_back();  // a comma at the end of the line
  if (!names_.empty()) columns_ = names_.size();
  if (rows_.empty()) {
    throw InputError(path, lines.empty() ? "an empty file" : "a header line and no row with a number",
                     "a row for each point, gate or segment", "Check that this is the file you meant");
  }
  VOLTLAP_DEMAND(columns_ > 0);
}

/// The separator that the lines have most evenly; a comma loses, as it may be a decimal one.
void SourceTable::find_separator(const std::vector<std::string>& lines) {
  const std::size_t looked_at = std::min<std::size_t>(lines.size(), 20);
  for (const char candidate : {';', '\t', ',', ' '}) {
    separator_ = candidate;
    std::size_t with = 0;
    for (std::size_t i = 0; i < looked_at; ++i) with += split(lines[i]).size() > 1;
    if (looked_at > 0 && with == looked_at) return;
  }
}

std::vector<std::string> SourceTable::split(const std::string& line) const {
  std::vector<std::string> fields;
  if (separator_ == ' ') {
    for (std::size_t from = line.find_first_not_of(" \t"); from != std::string::npos;) {
      const std::size_t end = line.find_first_of(" \t\r", from);
      fields.push_back(trimmed(line.substr(from, end - from)));
      from = end == std::string::npos ? end : line.find_first_not_of(" \t\r", end);
    }
    return fields;
  }
  for (std::size_t from = 0;;) {
    const std::size_t end = line.find(separator_, from);
    fields.push_back(trimmed(std::string_view(line).substr(from, end - from)));
    if (end == std::string::npos) return fields;
    from = end + 1;
  }
}

std::optional<double> SourceTable::parsed(std::string field) const {
  if (separator_ != ',') std::replace(field.begin(), field.end(), ',', '.');
  if (field.starts_with('+')) field.erase(0, 1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

bool SourceTable::has_number(const std::vector<std::string>& fields) const {
  return std::any_of(fields.begin(), fields.end(), [&](const std::string& field) {
    return parsed(field).has_value();
  });
}

const std::string& SourceTable::unit(std::size_t column) const {
  return column < units_.size() ? units_[column] : kNothing;
}

const std::string& SourceTable::text(std::size_t row, std::size_t column) const {
  VOLTLAP_DEMAND(row < rows_.size());
  return column < rows_[row].fields.size() ? rows_[row].fields[column] : kNothing;
}

double SourceTable::number(std::size_t row, std::size_t column) const {
  const std::string& field = text(row, column);
  const std::optional<double> value = parsed(field);
  if (!value || !std::isfinite(*value)) {
    const std::string name = column < names_.size() ? names_[column] : fmt::format("column {}", column + 1);
    throw InputError(fmt::format("{}, {}", place(row), name), fmt::format("\"{}\"", field), "a finite number",
                     "Correct the field, or remove the row");
  }
  return *value;
}

std::string SourceTable::place(std::size_t row) const {
  VOLTLAP_DEMAND(row < rows_.size());
  return fmt::format("{}:{}", path_, rows_[row].line);
}

}  // namespace voltlap::plant
