// SPDX-License-Identifier: Apache-2.0
// Roles from the columns of a table.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "core/errors.hpp"
#include "io/logs/channel_builder.hpp"

namespace voltlap::plant {
namespace {

const std::vector<double>& column_of(const MeasuredTable& table, const RoleMap& map, const std::string& column,
                                     const std::string& role) {
  const int index = table.find(column);
  if (index >= 0) return table.values[static_cast<std::size_t>(index)];
  throw InputError(table.path, fmt::format("no column \"{}\" among {}", column, fmt::join(table.columns, ", ")),
                   fmt::format("that column for the role {} ({})", role, map.source),
                   "Correct the map or the file");
}

/// Seconds of the log's clock, row by row.
std::vector<double> clock_of(DriveLog& log, const RoleMap& map, const MeasuredTable& table,
                             const RoleSource& source, bool main) {
  const RoleSource* time = map.find("time");
  const std::string column = !source.time.empty() ? source.time : time != nullptr ? time->column : std::string();
  if (column.empty()) {
    throw InputError(map.source, "no time column for " + table.path, "the role time, or time = \"...\" beside file",
                     "Add it to the map");
  }
  const bool own = time != nullptr && source.time.empty();
  std::vector<double> out = column_of(table, map, column, "time");
  for (double& t : out) t = t * (own ? time->scale : 1.0) + (own ? time->offset : 0.0) + source.shift_s;
  if (!main && is_absolute(log.origin_s) && !out.empty() && is_absolute(out.front())) {
    for (double& t : out) t -= log.origin_s;
  }
  return out;
}

/// Rows of one column that belong to several numbers, told by another column.
void add_indexed(DriveLog& log, const RoleMap& map, const MeasuredTable& table, const std::string& role,
                 const RoleSource& source, const std::vector<double>& clock) {
  const std::vector<double>& values = column_of(table, map, source.column, role);
  const std::vector<double>& index = column_of(table, map, source.index, role);
  std::map<long, ChannelBuilder> builders;
  for (std::size_t row = 0; row < clock.size(); ++row) {
    if (!std::isfinite(index[row])) continue;
    const long n = std::lround(index[row]) - source.first.value_or(1) + 1;
    if (n < 1) continue;
    auto at = builders.find(n);
    if (at == builders.end()) {
      at = builders.try_emplace(n, log, with_number(role, n), source, "column " + source.column).first;
    }
    at->second.add(clock[row], values[row]);
  }
  for (auto& [n, builder] : builders) builder.finish();
}

void add_column(DriveLog& log, const RoleMap& map, const MeasuredTable& table, const std::string& role,
                const std::string& column, const RoleSource& source, const std::vector<double>& clock) {
  const std::vector<double>& values = column_of(table, map, column, role);
  ChannelBuilder builder(log, role, source, "column " + column);
  // An empty field of a table with several rates is no sample at all.
  for (std::size_t row = 0; row < clock.size(); ++row) {
    if (std::isfinite(values[row])) builder.add(clock[row], values[row]);
  }
  builder.finish();
}

/// Columns c1_v, c2_v, ... for c<n>_v.
std::map<long, std::string> numbered_columns(const MeasuredTable& table, const RoleSource& source) {
  std::map<long, std::string> out;
  for (const std::string& column : table.columns) {
    if (const auto n = number_in(source.column, column)) out[*n - source.first.value_or(1) + 1] = column;
  }
  return out;
}

}  // namespace

void add_table_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                        const std::map<std::string, RoleSource>& roles, bool main) {
  const MeasuredTable table = read_measured_table(path);
  for (const std::string& repair : table.repairs)
    log.defects.push_back({"cut off", "", 1, 0.0, path + ": " + repair});
  for (const auto& [role, source] : roles) {
    if (role == "time") continue;
    const std::vector<double> clock = clock_of(log, map, table, source, main);
    if (!source.index.empty()) {
      add_indexed(log, map, table, role, source, clock);
    } else if (is_numbered(role)) {
      const auto columns = numbered_columns(table, source);
      if (columns.empty()) static_cast<void>(column_of(table, map, source.column, role));
      for (const auto& [n, column] : columns)
        add_column(log, map, table, with_number(role, n), column, source, clock);
    } else {
      add_column(log, map, table, role, source.column, source, clock);
    }
  }
}

}  // namespace voltlap::plant
