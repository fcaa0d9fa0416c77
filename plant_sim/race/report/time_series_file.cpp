// SPDX-License-Identifier: Apache-2.0
#include "race/report/time_series_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

long long samples_per_line(double rate_hz) {
  const double every = TimeSeriesFile::kSamplesPerSecond / rate_hz;
  if (!(rate_hz > 0.0) || every < 1.0 || every > 1e6 || std::abs(every - std::round(every)) > 1e-9 * every) {
    throw InputError("--rate", fmt::format("{} Hz", rate_hz), "10 Hz or an even part of it (10, 5, 2, 1, 0.5, 0.1 ...)",
                     "Choose one of these");
  }
  return std::llround(every);
}

}  // namespace

TimeSeriesFile::TimeSeriesFile(const std::string& path, double rate_hz, const RunDescription& run,
                               const VehicleParameters& car)
    : every_(samples_per_line(rate_hz)), file_(path) {
  file_.write(fmt::format("# voltlap {} endurance: {} on {}, laps {}, lap start {}, cells {}, seed {}\n",
                          VOLTLAP_VERSION, run.vehicle, run.course, run.laps, run.lap_start, run.cells, run.seed));
  for (const auto& [key, value] : parameter_values(car)) file_.write(fmt::format("# {} = {}\n", key, value));
  columns(car.battery.cells_in_series);
}

void TimeSeriesFile::columns(int cells) {
  file_.write(
      "time_s,distance_m,lap,speed_mps,target_mps,accelerator,brake,pack_current_a,pack_voltage_v,dc_link_v,"
      "phase_current_a,discharge_limit_a,charge_limit_a,limit_reason,soc,bms_soc,battery_temperature_c,"
      "motor_temperature_c,front_rotor_c,rear_rotor_c");
  for (const char* kind : {"voltage_v", "temperature_c"}) {
    for (int i = 1; i <= cells; ++i) file_.write(fmt::format(",cell_{}_{}", i, kind));
  }
  // At the end, so that a column that was there keeps its number.
  file_.write(
      ",lap_distance_m,speed_kmh,power_kw,power_mean_500ms_kw,longitudinal_mps2,lateral_mps2,charge_drawn_ah\n");
}

void TimeSeriesFile::add(const TimeSample& s) {
  VOLTLAP_DEMAND(s.cell_voltage_v != nullptr && s.cell_temperature_c != nullptr);
  VOLTLAP_DEMAND(s.cell_voltage_v->size() == s.cell_temperature_c->size());
  if (count_++ % every_ != 0) return;
  line_.clear();
  auto out = std::back_inserter(line_);
  fmt::format_to(out, "{:.2f},{:.3f},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{:.4f},{:.4f},{:.3f},{:.1f},{:.1f},{},",
                 s.time_s, s.distance_m, s.lap, s.speed_mps, s.target_mps, s.accelerator, s.brake, s.pack_current_a,
                 s.pack_voltage_v, s.dc_link_v, s.phase_current_a, s.discharge_limit_a, s.charge_limit_a,
                 limit_reason_name(s.limit_reason));
  fmt::format_to(out, "{:.6f},", s.soc);
  if (!std::isnan(s.bms_soc)) fmt::format_to(out, "{:.6f}", s.bms_soc);  // none: an empty field
  fmt::format_to(out, ",{:.3f},{:.3f},{:.2f},{:.2f}", s.battery_temperature_c, s.motor_temperature_c, s.front_rotor_c,
                 s.rear_rotor_c);
  for (const double voltage : *s.cell_voltage_v) fmt::format_to(out, ",{:.4f}", voltage);
  for (const double temperature : *s.cell_temperature_c) fmt::format_to(out, ",{:.3f}", temperature);
  fmt::format_to(out, ",{:.3f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.6f}\n", s.lap_distance_m, 3.6 * s.speed_mps,
                 1e-3 * s.power_w, 1e-3 * s.power_mean_w, s.longitudinal_mps2, s.lateral_mps2, s.charge_drawn_ah);
  file_.write(line_);
}

}  // namespace voltlap::plant
