// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voltlap::plant {
namespace {

std::string laps_text(int laps) {
  return fmt::format("{} {}", laps, laps == 1 ? "lap" : "laps");
}

std::string weakest_cell_text(const RunDescription& run, const VehicleParameters& car,
                              const EnduranceResult& result) {
  const std::string cell =
      cells_alike(run, car) ? "its cells, all alike," : fmt::format("its weakest cell, no. {},", result.min_cell);
  return fmt::format("{} sagged to {:.3f} V", cell, result.min_cell_voltage_v);
}

std::string lost_nodes_text(const EnduranceResult& result) {
  std::string out;
  for (const LostNodeRow& row : result.lost_nodes) {
    out += fmt::format(" Node {} was lost {} after power-on.", row.node, duration_text(row.time_s));
  }
  return out;
}

std::string failure_text(const RunDescription& run, const EnduranceResult& result) {
  if (!was_ready_to_drive(result)) return fmt::format("it did not start: {}", result.failure_cause);
  const std::string where =
      run.lap_start == "drive" ? "" : fmt::format(", in lap {} of {}", result.laps + 1, run.laps);
  return fmt::format("after {}{}, {}", duration_text(result.failure_time_s), where, result.failure_cause);
}

}  // namespace

bool was_ready_to_drive(const EnduranceResult& result) { return result.extreme_times.battery_temp_s > 0.0; }

bool cells_alike(const RunDescription& run, const VehicleParameters& car) {
  return run.cells == "representative" || car.battery.cells.empty();
}

std::string duration_text(double seconds) {
  const long long whole = std::llround(seconds);
  return fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

std::string regeneration_text(const EnduranceResult& result) {
  const double net = result.energy_out_kwh, back = result.energy_back_kwh;
  if (!(net > 0.0)) return fmt::format("{:.3f} kWh", back);
  return fmt::format("{:.3f} kWh, {:.1f} % of what was taken: {:.1f} % more range", back, 100.0 * back / (net + back),
                     100.0 * back / net);
}

std::string limits_text(const EnduranceResult& result) {
  std::string out;
  for (std::size_t i = 1; i < kLimitReasons; ++i) {
    if (result.limit_active_s[i] <= 0.0) continue;
    out += fmt::format("{}{} ", out.empty() ? "" : ", ", limit_reason_name(i));
    out += result.limit_active_s[i] < 0.05 ? "under 0.1 s" : fmt::format("{:.1f} s", result.limit_active_s[i]);
  }
  return out.empty() ? "none" : out;
}

std::string headline(const RunDescription& run, const VehicleParameters& car, const EnduranceResult& result) {
  const bool drive = run.lap_start == "drive", stood = result.finished && !drive && result.laps == 0;
  const std::string course = drive ? "the recorded drive " + run.course : laps_text(run.laps) + " of " + run.course;
  std::string out = run.vehicle;
  if (stood) {
    out += fmt::format(" stood for {}", duration_text(result.total_time_s));
  } else if (result.finished) {
    out += fmt::format(" finished {} in {}", course, duration_text(result.total_time_s));
  } else {
    out += fmt::format(" did not finish {}: {}", course, failure_text(run, result));
  }
  if (!was_ready_to_drive(result)) return out + "." + lost_nodes_text(result);
  return out + fmt::format("{} {:.1f} % charge left. Its battery reached {:.1f} °C, and {}.{}",
                           result.finished ? " with" : ". It stopped with", result.end_soc_pct,
                           result.max_battery_temp_c, weakest_cell_text(run, car, result), lost_nodes_text(result));
}

}  // namespace voltlap::plant
