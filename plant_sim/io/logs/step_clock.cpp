// SPDX-License-Identifier: Apache-2.0
#include "io/logs/step_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "io/logs/plain_columns.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::size_t repeats(const std::vector<double>& time) {
  std::size_t out = 0;
  for (std::size_t row = 1; row < time.size(); ++row) out += time[row] == time[row - 1] ? 1 : 0;
  return out;
}

/// Rows of one step: its clock runs on.
struct Step {
  std::size_t first, end;
};

std::vector<Step> steps_of(const std::vector<double>& clock) {
  std::vector<Step> out;
  for (std::size_t row = 0; row < clock.size(); ++row) {
    if (out.empty() || clock[row] < clock[row - 1] || std::isnan(clock[row]) != std::isnan(clock[row - 1]))
      out.push_back({row, row});
    out.back().end = row + 1;
  }
  return out;
}

/// Dates are cut off, not rounded: the step began at the latest that any of its rows says, or less than a unit of the
/// date after.
double begin_of(const Step& step, const std::vector<double>& date_s, const std::vector<double>& clock_s) {
  double out = -std::numeric_limits<double>::infinity();
  for (std::size_t row = step.first; row < step.end; ++row) {
    if (std::isfinite(date_s[row])) out = std::max(out, date_s[row] - clock_s[row]);
  }
  return std::isfinite(out) ? out : kNone;
}

}  // namespace

void refine_by_step_clock(const RoleMap& map, MeasuredTable& table) {
  constexpr double kDate_s = 1.0;
  constexpr std::size_t kFew = 50;  // a row in so many repeats a date where a step ends
  const auto time = map.roles.find("time");
  if (time == map.roles.end() || table.find(time->second.column) < 0) return;
  std::vector<double>& dates = table.values[table.index_for(time->second.column, "time", map.source)];
  const std::optional<StepClock> clock = step_clock(table);
  if (!clock) return;
  const std::size_t coarse = repeats(dates), fine = repeats(table.values[clock->column]);
  if (kFew * coarse <= table.rows() || 2 * fine > coarse) return;
  std::vector<double> date_s = dates, clock_s = table.values[clock->column];
  for (double& value : date_s) value *= time->second.scale;
  for (double& value : clock_s) value *= clock->scale;
  double last_s = kNone;
  for (const Step& step : steps_of(clock_s)) {
    double begin_s = begin_of(step, date_s, clock_s);
    if (last_s > begin_s - kDate_s && last_s < begin_s + kDate_s) begin_s = last_s;
    for (std::size_t row = step.first; row < step.end; ++row) {
      const double now_s = begin_s + clock_s[row];
      dates[row] = now_s / time->second.scale;
      if (std::isfinite(now_s)) last_s = now_s;
    }
  }
  table.repairs.push_back(fmt::format("time: \"{}\" is too coarse for these rows; \"{}\" beside it tells the rest",
                                      time->second.column, table.columns[clock->column]));
}

}  // namespace voltlap::plant
