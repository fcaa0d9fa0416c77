// SPDX-License-Identifier: Apache-2.0
#include "race/report/summary_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "io/table_file.hpp"
#include "race/report/run_text.hpp"

namespace voltlap::plant {
namespace {

std::string joined(std::vector<std::string> settings) {
  std::sort(settings.begin(), settings.end());
  return fmt::format("{}", fmt::join(settings, " "));
}

enum class ErrorKind { kAbsolute, kPercent };

struct Line {
  const char* name;
  const char* unit;
  int digits;
  double value;
  std::optional<double> reference;
  ErrorKind error;
};

std::string text(const Line& line) {
  const double shown = std::abs(line.value) < 0.5 * std::pow(10.0, -line.digits) ? 0.0 : line.value;  // no "-0.0"
  std::string out = fmt::format("  {:<24}{:>10.{}f} {:<4}", line.name, shown, line.digits, line.unit);
  if (line.reference) {
    const double difference = line.value - *line.reference;
    out += fmt::format("{:>10.{}f} {:<4}", *line.reference, line.digits, line.unit);
    out += line.error == ErrorKind::kPercent
               ? fmt::format("{:>+9.2f} %", 100.0 * difference / *line.reference)
               : fmt::format("{:>+9.2f} {}", difference, std::string(line.unit) == "%" ? "points" : line.unit);
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out + '\n';
}

}  // namespace

std::optional<ReferenceRow> find_reference(const std::string& path, const RunDescription& run) {
  const InputTable table(path);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const bool same = table.text(i, "vehicle") == run.vehicle && table.text(i, "track") == run.course &&
                      table.text(i, "laps") == std::to_string(run.laps) &&
                      table.text(i, "lap_start") == run.lap_start && table.text(i, "settings") == joined(run.settings);
    if (!same) continue;
    return ReferenceRow{table.text(i, "run"), table.number(i, "end_soc_pct"), table.number(i, "max_battery_temp_c"),
                        table.number(i, "total_time_s"), table.number(i, "max_battery_current_a"),
                        table.number(i, "min_pack_voltage_v"), table.number(i, "max_speed_mps")};
  }
  return std::nullopt;
}

std::string summary_table(const RunDescription& run, const EnduranceResult& result,
                          const std::optional<ReferenceRow>& reference) {
  const auto of = [&](double ReferenceRow::* value) {
    return reference ? std::optional<double>((*reference).*value) : std::nullopt;
  };
  const Line lines[] = {
      {"end SOC", "%", 1, result.end_soc_pct, of(&ReferenceRow::end_soc_pct), ErrorKind::kAbsolute},
      {"battery, hottest", "degC", 1, result.max_battery_temp_c, of(&ReferenceRow::max_battery_temp_c),
       ErrorKind::kAbsolute},
      {"total time", "s", 1, result.total_time_s, of(&ReferenceRow::total_time_s), ErrorKind::kPercent},
      {"peak battery current", "A", 1, result.max_battery_current_a, of(&ReferenceRow::max_battery_current_a),
       ErrorKind::kPercent},
      {"lowest pack voltage", "V", 1, result.min_pack_voltage_v, of(&ReferenceRow::min_pack_voltage_v),
       ErrorKind::kPercent},
      {"top speed", "m/s", 1, result.max_speed_mps, of(&ReferenceRow::max_speed_mps), ErrorKind::kAbsolute},
      {"lowest cell voltage", "V", 3, result.min_cell_voltage_v, std::nullopt, ErrorKind::kAbsolute},
      {"energy out", "kWh", 3, result.energy_out_kwh, std::nullopt, ErrorKind::kAbsolute},
      {"distance", "km", 3, result.distance_m / 1000.0, std::nullopt, ErrorKind::kAbsolute},
  };
  std::string out =
      result.finished
          ? fmt::format("Finished {} on {} in {}.\n", run.vehicle, run.course, duration_text(result.total_time_s))
          : fmt::format("FAILED {} on {} after {:.2f} s, {} laps done: {}.\n", run.vehicle, run.course,
                        result.failure_time_s, result.laps, result.failure_cause);
  out += fmt::format("  {:<24}{:>10}", "", "this run");
  out += reference ? fmt::format("{:>15}{:>14}\n", "reference", "error") : "\n";
  for (const Line& line : lines) out += text(line);
  out += fmt::format("  limits that held back: {}\n  lowest cell: {}   energy ledger closes to {:.4f} %   frames: {}\n",
                     limits_text(result), result.min_cell, result.energy_ledger_error_pct, result.frames);
  if (result.energy_back_kwh >= 5e-4) out += fmt::format("  regenerated: {}\n", regeneration_text(result));
  if (reference) out += fmt::format("  reference: study of 2016, Tables 8.2 and 8.3, row {}\n", reference->run);
  return out;
}

std::string bus_statistics_text(const BusStatistics& bus, double simulated_s, double wall_s) {
  std::string out =
      fmt::format("  bus: {}, {}, {:.1f} times real time", bus.interface, bus.pacing, simulated_s / wall_s);
  if (bus.pacing == "realtime") {
    out += fmt::format(", {} late steps, the latest by {:.1f} ms", bus.late_steps, 1e3 * bus.late_worst_s);
  }
  out += '\n';
  const std::pair<std::uint64_t, const char*> findings[] = {
      {bus.foreign_frames, "foreign frames"}, {bus.missing_frames, "frames announced and never seen"},
      {bus.dropped_frames, "frames not read in time: hashes and counts are not whole"},
      {bus.error_frames, "error frames"}, {bus.send_retries, "retries with a full queue"}};
  for (const auto& [count, what] : findings) {
    if (count > 0) out += fmt::format("  bus: {} {}\n", count, what);
  }
  return out;
}

}  // namespace voltlap::plant
