// SPDX-License-Identifier: Apache-2.0
// Roles from the columns of a table.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/channel_builder.hpp"
#include "io/logs/plain_columns.hpp"
#include "io/logs/row_clock.hpp"

namespace voltlap::plant {
namespace {

/// A table, the map that says which of its columns plays which role, and the log that the roles go into.
class TableChannels {
 public:
  TableChannels(DriveLog& log, const RoleMap& map, const MeasuredTable& table, bool main)
      : log_(log), map_(map), table_(table), main_(main) {
    const RoleSource* time = map.find("time");
    if (time != nullptr) time_ = with_file_unit(*time, "time", table, map.source, log.notes);
  }

  void add(const std::string& role, const RoleSource& source);

 private:
  [[nodiscard]] const std::vector<double>& column_of(const std::string& column, const std::string& role) const;
  [[nodiscard]] const RowClock& clock_of(const RoleSource& source);
  [[nodiscard]] RowClock read_clock(const std::string& column, const RoleSource& source) const;
  [[nodiscard]] bool is_dense(const RoleSource& source) const;
  void note_clock(const RowClock& clock);
  void read_words(const std::string& role, const std::string& column, std::vector<double>& values);
  void fill(ChannelBuilder& builder, const RowClock& clock, const std::vector<double>& values) const;
  [[nodiscard]] std::map<long, std::string> numbered_columns(const RoleSource& source) const;
  void add_column(const std::string& role, const std::string& column, const RoleSource& source,
                  const RowClock& clock);
  void add_indexed(const std::string& role, const RoleSource& source, const RowClock& clock);

  DriveLog& log_;
  const RoleMap& map_;
  const MeasuredTable& table_;
  bool main_;
  std::optional<RoleSource> time_;  ///< in the unit that the file gives
  std::map<std::tuple<std::string, double, bool>, RowClock> clocks_;  ///< by column, shift, and whether spread
};

/// Kelvin taken for degC, and percent taken for shares of 1, are brought to what the role is in, and said.
RoleSource with_plausible_unit(const RoleSource& source, const std::string& role, const std::vector<double>& values,
                               DriveLog& log) {
  constexpr double kKelvinLow = 233.0, kKelvinHigh = 353.0, kZeroCelsius = 273.15, kPercentLeast = 1.5,
                   kPercentMost = 110.0;
  double low = 1e300, high = -1e300;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value * source.scale + source.offset);
    high = std::max(high, value * source.scale + source.offset);
  }
  RoleSource out = source;
  if ((role.starts_with("temperature_") || role == "ambient") && low > kKelvinLow && high < kKelvinHigh) {
    out.offset -= kZeroCelsius;
    log.notes.push_back(fmt::format("{} is in K ({:.1f} to {:.1f}): brought to degC", role, low, high));
  }
  const bool is_share = role == "soc" || role == "accelerator" || role == "brake";
  const bool untold = source.unit.empty() && source.scale == 1.0 && source.offset == 0.0;
  if (is_share && untold && high > kPercentLeast && high < kPercentMost && low > -kPercentMost / 10.0) {
    out.scale = 0.01;
    log.notes.push_back(fmt::format("{} is in % ({:.4g} to {:.4g}): divided by 100", role, low, high));
  }
  return out;
}

const std::vector<double>& TableChannels::column_of(const std::string& column, const std::string& role) const {
  return table_.values[table_.index_for(column, role, map_.source)];
}

/// Whether nearly every row has the channel; of numbered ones, the first.
bool TableChannels::is_dense(const RoleSource& source) const {
  constexpr double kDense = 0.9;
  const auto numbered = numbered_columns(source);
  const int at = table_.find(numbered.empty() ? source.column : numbered.begin()->second);
  if (at < 0) return false;
  const std::vector<double>& values = table_.values[static_cast<std::size_t>(at)];
  const auto count = std::count_if(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  return static_cast<double>(count) > kDense * static_cast<double>(values.size());
}

/// Seconds of the log's clock, of the rows in their order.
const RowClock& TableChannels::clock_of(const RoleSource& source) {
  const std::string column = !source.time.empty() ? source.time : time_ ? time_->column : std::string();
  if (column.empty()) {
    throw InputError(map_.source, "no time column for " + table_.path,
                     "the role time, or time = \"...\" beside file", "Add it to the map");
  }
  // Rows of one stamp are samples one after the other only where each has the channel; else they are one moment.
  const bool dense = source.index.empty() && is_dense(source);
  const auto key = std::tuple(column, source.shift_s, dense);
  if (const auto known = clocks_.find(key); known != clocks_.end()) return known->second;
  RowClock& clock = clocks_[key] = read_clock(column, source);
  if (dense) clock.spread();
  note_clock(clock);
  return clock;
}

RowClock TableChannels::read_clock(const std::string& column, const RoleSource& source) const {
  const bool own = time_.has_value() && source.time.empty();
  std::vector<double> stamps = column_of(column, "time");
  for (double& t : stamps) t = t * (own ? time_->scale : 1.0) + (own ? time_->offset : 0.0) + source.shift_s;
  if (!main_ && is_absolute(log_.origin_s) && !stamps.empty() && is_absolute(stamps.front())) {
    for (double& t : stamps) t -= log_.origin_s;
  }
  VOLTLAP_DEMAND(stamps.size() == table_.rows());
  return row_clock(stamps);
}

void TableChannels::note_clock(const RowClock& clock) {
  for (const CanDefect& defect : clock.defects) {
    log_.defects.push_back({defect.kind, "", defect.count, defect.first_s,
                            fmt::format("{}: {} rows: {}, first in row {}", table_.path, defect.count, defect.kind,
                                        defect.first_line)});
  }
  if (clock.rows_to_a_stamp > 0.0) {
    log_.notes.push_back(fmt::format("{}: some {:.0f} rows have one stamp: spread evenly between the stamps",
                                     table_.path, clock.rows_to_a_stamp));
  }
  for (const std::string& note : clock_notes(clock.parts, "row")) log_.notes.push_back(table_.path + ": " + note);
  for (const ClockPart& part : clock.parts) {
    if (part.begin == ClockPart::Begin::kAnew) log_.restarts_s.push_back(part.recorded_begin_s + part.shift_s);
  }
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
  if (source.optional && table_.find(source.column) < 0 && numbered_columns(source).empty()) return;
  const RowClock& clock = clock_of(source);
  if (!source.index.empty()) return add_indexed(role, source, clock);
  if (!is_numbered(role)) return add_column(role, source.column, source, clock);
  const auto columns = numbered_columns(source);
  if (columns.empty()) static_cast<void>(column_of(source.column, role));
  for (const auto& [n, column] : columns) add_column(with_number(role, n), column, source, clock);
}

void TableChannels::add_column(const std::string& role, const std::string& column, const RoleSource& given,
                               const RowClock& clock) {
  std::vector<double> values = column_of(column, role);
  RoleSource source = given;
  source.column = column;
  source = with_plausible_unit(with_file_unit(source, role, table_, map_.source, log_.notes), role, values, log_);
  if (role == "current" && source.discharge == DischargeSign::kAuto) {
    if (const auto signed_by = sign_by_state(table_, values)) log_.notes.push_back(*signed_by);
  }
  if (role.starts_with("fault_")) read_words(role, column, values);
  ChannelBuilder builder(log_, role, source, "column " + column);
  fill(builder, clock, values);
  builder.finish();
}

/// An empty field of a table with several rates is no sample at all.
void TableChannels::fill(ChannelBuilder& builder, const RowClock& clock, const std::vector<double>& values) const {
  std::size_t left = 0;
  for (const double value : values) left += std::isfinite(value) ? 1 : 0;
  for (std::size_t k = 0; k < clock.row.size(); ++k) {
    const double value = values[clock.row[k]];
    if (!std::isfinite(value)) continue;
    builder.add(clock.time_s[k], value);
    --left;
  }
  for (; left > 0; --left) builder.leave_out();
}

/// A word as a unit writes a fault: 0x0004, TRUE, OVERTEMP; 0 for none. Words without a number count from 1 on.
std::optional<double> fault_of(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* none : {"none", "no", "false", "off", "ok", "okay", "-", "--", "n/a", "normal"}) {
    if (word == none) return 0.0;
  }
  if (!word.starts_with("0x")) return std::nullopt;
  std::uint64_t bits = 0;
  const auto [end, error] = std::from_chars(word.data() + 2, word.data() + word.size(), bits, 16);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return static_cast<double>(bits);
}

/// Fields of a fault column that are no decimal numbers.
void TableChannels::read_words(const std::string& role, const std::string& column, std::vector<double>& values) {
  const MeasuredColumn& about = table_.about[static_cast<std::size_t>(table_.find(column))];
  std::vector<double> value_of;
  for (const std::string& word : about.words) {
    const auto number = fault_of(word);
    value_of.push_back(number.value_or(static_cast<double>(value_of.size() + 1)));
    if (!number) log_.notes.push_back(fmt::format("{}: \"{}\" is counted as {:.0f}", role, word, value_of.back()));
  }
  std::size_t read = 0;
  for (std::size_t row = 0; row < std::min(values.size(), about.word_of_row.size()); ++row) {
    if (std::isfinite(values[row]) || about.word_of_row[row] == 0) continue;
    values[row] = value_of[about.word_of_row[row] - 1U];
    ++read;
  }
  if (about.holes.words <= read) return;
  throw InputError(fmt::format("{}, column \"{}\"", table_.path, column),
                   fmt::format("more than {} different words", MeasuredColumn::kMostWords),
                   "a fault word: numbers, or few words", "Name another column for the role " + role);
}

/// Rows of one column that belong to several numbers, told by another column.
void TableChannels::add_indexed(const std::string& role, const RoleSource& source, const RowClock& clock) {
  const std::vector<double>& values = column_of(source.column, role);
  const std::vector<double>& index = column_of(source.index, role);
  std::map<long, ChannelBuilder> builders;
  for (std::size_t k = 0; k < clock.row.size(); ++k) {
    const std::size_t row = clock.row[k];
    if (!std::isfinite(index[row])) continue;
    const long n = std::lround(index[row]) - source.first.value_or(1) + 1;
    if (n < 1) continue;
    auto at = builders.find(n);
    if (at == builders.end()) {
      at = builders.try_emplace(n, log_, with_number(role, n), source, "column " + source.column).first;
    }
    at->second.add(clock.time_s[k], values[row]);
  }
  for (auto& [n, builder] : builders) builder.finish();
}

}  // namespace

void add_table_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                        const std::map<std::string, RoleSource>& roles, bool main) {
  const MeasuredTable table = read_measured_table(path);
  for (const std::string& repair : table.repairs)
    log.defects.push_back({"cut off", "", 1, 0.0, path + ": " + repair});
  for (const std::string& note : table.notes) log.notes.push_back(path + ": " + note);
  if (main) log.notes.insert(log.notes.end(), map.notes.begin(), map.notes.end());
  if (const RoleSource* time = map.find("time"); time != nullptr && table.find(time->column) >= 0) {
    const auto& said = table.about[static_cast<std::size_t>(table.find(time->column))].notes;
    log.notes.insert(log.notes.end(), said.begin(), said.end());
  }
  TableChannels channels(log, map, table, main);
  for (const auto& [role, source] : roles) {
    if (role != "time") channels.add(role, source);
  }
}

}  // namespace voltlap::plant
