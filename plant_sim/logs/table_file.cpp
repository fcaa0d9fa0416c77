// SPDX-License-Identifier: Apache-2.0
#include "logs/table_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <memory>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// Whole text of a file; zlib passes a plain file through as it is.
std::string text_of(const std::string& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(path.c_str(), "rb"), gzclose);
  if (!in) throw InputError(fmt::format("{}: cannot be opened; check the path and that you may read it", path));
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  for (;;) {
    const int got = gzread(in.get(), block.data(), static_cast<unsigned>(block.size()));
    if (got < 0) {
      throw InputError(path, "a gzip stream that breaks off or is damaged", "a whole file",
                       "Copy or compress the recording again");
    }
    if (got == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
  }
}

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
  const std::string text = text_of(path);
  MeasuredTable table;
  table.path = path;
  std::size_t number = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::string_view line(text.data() + from, end - from);
    const bool last = end + 1 >= text.size();
    from = end + 1;
    ++number;
    if (trimmed(line).empty() || line[0] == '#') continue;
    const auto fields = split(line);
    if (table.columns.empty()) {
      for (const auto field : fields) table.columns.emplace_back(trimmed(field));
      table.values.resize(fields.size());
    } else if (fields.size() != table.columns.size()) {
      if (last && fields.size() < table.columns.size()) {
        table.repairs.push_back(fmt::format("last line {} is cut off: left out", number));
        continue;
      }
      throw InputError(fmt::format("{}:{}", path, number), fmt::format("{} fields", fields.size()),
                       fmt::format("{} ({})", table.columns.size(), fmt::join(table.columns, ",")),
                       "Complete the row or remove it");
    } else {
      for (std::size_t k = 0; k < fields.size(); ++k) table.values[k].push_back(number_of(fields[k]));
      table.lines.push_back(number);
    }
  }
  if (table.lines.empty()) {
    throw InputError(path, table.columns.empty() ? "an empty file" : "a header line without rows",
                     "a header line with column names and rows below it",
                     "Check that this is the recording you meant");
  }
  return table;
}

}  // namespace voltlap::plant
