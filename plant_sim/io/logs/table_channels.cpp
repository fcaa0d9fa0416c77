// SPDX-License-Identifier: Apache-2.0
// Roles from the columns of a table.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/channel_builder.hpp"

namespace voltlap::plant {
namespace {

/// A table, the map that says which of its columns plays which role, and the log that the roles go into.
class TableChannels {
 public:
  TableChannels(DriveLog& log, const RoleMap& map, const MeasuredTable& table, bool main)
      : log_(log), map_(map), table_(table), main_(main) {}

  void add(const std::string& role, const RoleSource& source);

 private:
  [[nodiscard]] const std::vector<double>& column_of(const std::string& column, const std::string& role) const;
  [[nodiscard]] std::vector<double> clock_of(const RoleSource& source) const;
  [[nodiscard]] std::map<long, std::string> numbered_columns(const RoleSource& source) const;
  void add_column(const std::string& role, const std::string& column, const RoleSource& source,
                  const std::vector<double>& clock);
  void add_indexed(const std::string& role, const RoleSource& source, const std::vector<double>& clock);

  DriveLog& log_;
  const RoleMap& map_;
  const MeasuredTable& table_;
  bool main_;
};

const std::vector<double>& TableChannels::column_of(const std::string& column, const std::string& role) const {
  return table_.values[table_.index_for(column, role, map_.source)];
}

/// Seconds of the log's clock, row by row.
std::vector<double> TableChannels::clock_of(const RoleSource& source) const {
  const RoleSource* time = map_.find("time");
  const std::string column = !source.time.empty() ? source.time : time != nullptr ? time->column : std::string();
  if (column.empty()) {
    throw InputError(map_.source, "no time column for " + table_.path,
                     "the role time, or time = \"...\" beside file", "Add it to the map");
  }
  const bool own = time != nullptr && source.time.empty();
  std::vector<double> out = column_of(column, "time");
  for (double& t : out) t = t * (own ? time->scale : 1.0) + (own ? time->offset : 0.0) + source.shift_s;
  if (!main_ && is_absolute(log_.origin_s) && !out.empty() && is_absolute(out.front())) {
    for (double& t : out) t -= log_.origin_s;
  }
  VOLTLAP_DEMAND(out.size() == table_.rows());
  return out;
}

/// Columns c1_v, c2_v, ... for c<n>_v.
std::map<long, std::string> TableChannels::numbered_columns(const RoleSource& source) const {
  std::map<long, std::string> out;
  for (const std::string& column : table_.columns) {
    if (const auto n = number_in(source.column, column)) out[*n - source.first.value_or(1) + 1] = column;
  }
  return out;
}

void TableChannels::add(const std::string& role, const RoleSource& source) {
  const std::vector<double> clock = clock_of(source);
  if (!source.index.empty()) return add_indexed(role, source, clock);
  if (!is_numbered(role)) return add_column(role, source.column, source, clock);
  const auto columns = numbered_columns(source);
  if (columns.empty()) static_cast<void>(column_of(source.column, role));
  for (const auto& [n, column] : columns) add_column(with_number(role, n), column, source, clock);
}

void TableChannels::add_column(const std::string& role, const std::string& column, const RoleSource& source,
                               const std::vector<double>& clock) {
  const std::vector<double>& values = column_of(column, role);
  VOLTLAP_DEMAND(values.size() == clock.size());
  ChannelBuilder builder(log_, role, source, "column " + column);
  // An empty field of a table with several rates is no sample at all.
  for (std::size_t row = 0; row < clock.size(); ++row) {
    if (std::isfinite(values[row])) builder.add(clock[row], values[row]);
  }
  builder.finish();
}

/// Rows of one column that belong to several numbers, told by another column.
void TableChannels::add_indexed(const std::string& role, const RoleSource& source, const std::vector<double>& clock) {
  const std::vector<double>& values = column_of(source.column, role);
  const std::vector<double>& index = column_of(source.index, role);
  VOLTLAP_DEMAND(values.size() == clock.size() && index.size() == clock.size());
  std::map<long, ChannelBuilder> builders;
  for (std::size_t row = 0; row < clock.size(); ++row) {
    if (!std::isfinite(index[row])) continue;
    const long n = std::lround(index[row]) - source.first.value_or(1) + 1;
    if (n < 1) continue;
    auto at = builders.find(n);
    if (at == builders.end()) {
      at = builders.try_emplace(n, log_, with_number(role, n), source, "column " + source.column).first;
    }
    at->second.add(clock[row], values[row]);
  }
  for (auto& [n, builder] : builders) builder.finish();
}

}  // namespace

void add_table_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                        const std::map<std::string, RoleSource>& roles, bool main) {
  const MeasuredTable table = read_measured_table(path);
  for (const std::string& repair : table.repairs)
    log.defects.push_back({"cut off", "", 1, 0.0, path + ": " + repair});
  TableChannels channels(log, map, table, main);
  for (const auto& [role, source] : roles) {
    if (role != "time") channels.add(role, source);
  }
}

}  // namespace voltlap::plant
