// SPDX-License-Identifier: Apache-2.0
// Every numeric column of a table.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/plot/plotted_signals.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<std::string_view, 10> kTimeNames = {"time",      "t",       "timestamp", "timestamps", "seconds",
                                                         "time since start", "elapsed", "elapsed time", "zeit", "sec"};
/// Ends of column names that are a unit: pack_voltage_v.
constexpr std::array<std::pair<std::string_view, std::string_view>, 22> kEndings = {{
    {"_s", "s"},       {"_ms", "ms"},   {"_us", "us"},   {"_a", "A"},     {"_ma", "mA"},   {"_v", "V"},
    {"_mv", "mV"},     {"_c", "degC"},  {"_degc", "degC"}, {"_mps", "m/s"}, {"_kmh", "km/h"}, {"_rpm", "rpm"},
    {"_nm", "Nm"},     {"_kw", "kW"},   {"_w", "W"},     {"_wh", "Wh"},   {"_kwh", "kWh"}, {"_ah", "Ah"},
    {"_pct", "%"},     {"_m", "m"},     {"_bar", "bar"}, {"_hz", "Hz"},
}};

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

/// "Speed [km/h]", "Speed (km/h)" and speed_kmh: the name, and the unit as far as it is known.
SignalHead head_of(const std::string& column) {
  const std::size_t open = column.find_last_of("[(");
  if (open != std::string::npos && open > 0 && (column.back() == ']' || column.back() == ')')) {
    std::string name = column.substr(0, open);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    return {name, column.substr(open + 1, column.size() - open - 2), {}};
  }
  const std::string small = lower(column);
  for (const auto& [ending, unit] : kEndings) {
    const bool alone = ending.size() > 3 && small == ending.substr(1);  // rpm
    if (alone || (small.ends_with(ending) && small.size() > ending.size())) return {column, std::string(unit), {}};
  }
  return {column, {}, {}};
}

/// Seconds for one of a unit of time; 0 for any other unit.
double seconds_of(const std::string& unit) {
  const std::string small = lower(unit);
  if (small == "s" || small == "sec" || small == "seconds" || small.empty()) return 1.0;
  if (small == "ms" || small == "milliseconds") return 1e-3;
  if (small == "us" || small == "µs" || small == "microseconds") return 1e-6;
  if (small == "min") return 60.0;
  return small == "h" ? 3600.0 : 0.0;
}

bool never_decreases(const std::vector<double>& values) {
  double last = -INFINITY;
  std::size_t numbers = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (value < last) return false;
    last = value;
    ++numbers;
  }
  return 2 * numbers > values.size();
}

class TableSignals : public PlottedSignals {
 public:
  explicit TableSignals(const std::string& path) : table_(read_measured_table(path)) {
    for (const std::string& repair : table_.repairs) facts_.notes.push_back(repair);
    facts_.format = "table";
    facts_.frames = table_.rows();
    find_time();
    for (std::size_t k = 0; k < table_.columns.size(); ++k) add_column(k);
    if (!heads_.empty()) return;
    throw InputError(path, "no column with numbers beside the time", "at least one",
                     "Check that this is the recording you meant; commas separate columns");
  }

  void read(const SampleSink& sink, const ReadProgress&) override {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const std::vector<double>& values = table_.values[columns_[k]];
      VOLTLAP_DEMAND(values.size() == time_s_.size());
      // An empty field of a table with several rates is no sample at all.
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (std::isfinite(values[row]) && std::isfinite(time_s_[row])) sink(k, time_s_[row], values[row]);
      }
    }
  }
  [[nodiscard]] const std::vector<SignalHead>& heads() const override { return heads_; }
  [[nodiscard]] const RecordingFacts& facts() const override { return facts_; }

 private:
  void find_time();
  [[nodiscard]] int time_column() const;
  void run_forward();
  void add_column(std::size_t column);

  MeasuredTable table_;
  int time_column_ = -1;
  std::vector<double> time_s_;
  std::vector<std::size_t> columns_;
  std::vector<SignalHead> heads_;
  RecordingFacts facts_;
};

/// The column that is called so; else the first that never decreases, when its unit may be one of time.
int TableSignals::time_column() const {
  for (std::size_t k = 0; k < table_.columns.size(); ++k) {
    const SignalHead head = head_of(table_.columns[k]);
    std::string name = lower(head.name);
    for (const std::string_view ending : {"_s", "_ms", "_us"}) {
      if (name.ends_with(ending)) name.resize(name.size() - ending.size());
    }
    const bool is_time = std::find(kTimeNames.begin(), kTimeNames.end(), name) != kTimeNames.end();
    if (is_time && seconds_of(head.unit) > 0.0) return static_cast<int>(k);
  }
  if (!table_.values.empty() && never_decreases(table_.values[0]) && seconds_of(head_of(table_.columns[0]).unit) > 0.0)
    return 0;
  return -1;
}

void TableSignals::find_time() {
  time_column_ = time_column();
  if (time_column_ < 0) {
    for (std::size_t row = 0; row < table_.rows(); ++row) time_s_.push_back(static_cast<double>(row));
    facts_.notes.emplace_back("no column is called time or t: the rows are counted instead, one a second");
  } else {
    const auto column = static_cast<std::size_t>(time_column_);
    const double size_s = seconds_of(head_of(table_.columns[column]).unit);
    for (const double time : table_.values[column]) time_s_.push_back(time * size_s);
    facts_.notes.push_back(fmt::format("time is the column \"{}\"{}", table_.columns[column],
                                       size_s == 1.0 ? "" : fmt::format(", in units of {:g} s", size_s)));
  }
  run_forward();
}

/// Seconds since the first row. A clock that steps back is joined; rows without a time are left out.
void TableSignals::run_forward() {
  const auto first = std::find_if(time_s_.begin(), time_s_.end(), [](double t) { return std::isfinite(t); });
  if (first == time_s_.end()) {
    throw InputError(table_.path, "no number in the column of the time", "seconds",
                     "Give a column time_s, or a role map with --map");
  }
  const double begin = *first;
  facts_.start = start_text(begin);
  double shift = -begin, latest = 0.0;
  std::size_t untimed = 0, back = 0, back_line = 0;
  for (std::size_t row = 0; row < time_s_.size(); ++row) {
    double& time = time_s_[row];
    if (!std::isfinite(time)) {
      ++untimed;
      continue;
    }
    time += shift;
    if (time < latest) {
      shift += latest - time;
      time = latest;
      if (back++ == 0) back_line = table_.lines[row];
    }
    latest = time;
  }
  facts_.duration_s = latest;
  if (untimed > 0) facts_.notes.push_back(fmt::format("{} rows without a time are left out", untimed));
  if (back > 0) {
    facts_.notes.push_back(fmt::format("{} x the time steps back, first in line {}: joined, the clock goes on", back,
                                       back_line));
  }
}

void TableSignals::add_column(std::size_t column) {
  if (static_cast<int>(column) == time_column_) return;
  const std::vector<double>& values = table_.values[column];
  const auto numbers = std::count_if(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (numbers == 0) {
    facts_.notes.push_back(fmt::format("column {} has no number: left out", table_.columns[column]));
    return;
  }
  SignalHead head = head_of(table_.columns[column]);
  if (head.name.empty()) head.name = fmt::format("column {}", column + 1);
  head.source = fmt::format("column {}", column + 1);
  heads_.push_back(head);
  columns_.push_back(column);
}

}  // namespace

std::unique_ptr<PlottedSignals> table_signals(const std::string& path) { return std::make_unique<TableSignals>(path); }

}  // namespace voltlap::plant
