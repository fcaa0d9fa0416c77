// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_recording.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kRestShare = 0.01;  // of the largest current

/// Mean of the readings of rows `first` to `last` (exclusive); NaN without any.
double mean_of(const std::vector<double>& readings, std::size_t first, std::size_t last) {
  double sum = 0.0, count = 0.0;
  for (std::size_t row = first; row < last; ++row) {
    if (!std::isfinite(readings[row])) continue;
    sum += readings[row];
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::nan("");
}

/// How far [K, 1 sigma] the air may be from the start. A cell that is still off by d cools at d / tau: a rest of `s`
/// seconds in which it moved by no more than what the readings resolve leaves d within that times tau / s.
double air_within_k(const MeasuredRun& run, const std::vector<double>& readings) {
  constexpr double kTau_s = 3600.0;    // C / G of a cell in still air: 1200 s for a round one, an hour for a pouch
  constexpr double kResolved_k = 0.05; // of a mean of readings
  constexpr double kAlways_k = 0.2;    // air that is not the same everywhere
  const double quiet = kRestShare * run.current_a.cwiseAbs().maxCoeff();
  Index last = 0;
  while (last < run.rows() && std::abs(run.current_a(last)) <= quiet && (last == 0 || !run.is_reset(last)) &&
         std::abs(run.current_begin_a(last)) <= quiet)
    ++last;
  if (last < 3) return kFreeAir_k;
  const auto rows = static_cast<std::size_t>(last), third = rows / 3;
  const double rest_s = run.time_s(last - 1) - run.time_s(0);
  const double moved = std::abs(mean_of(readings, rows - third, rows) - mean_of(readings, 0, third));
  if (!std::isfinite(moved) || rest_s <= 0.0) return kFreeAir_k;
  std::vector<double> known;
  std::copy_if(readings.begin(), readings.end(), std::back_inserter(known), [](double t) { return std::isfinite(t); });
  const double within = moved + kResolved_k + 0.5 * smallest_step(known, 1e-3);
  return std::hypot(kAlways_k, within * kTau_s / rest_s);
}

}  // namespace

std::string_view name_of(AirFrom from) {
  return from == AirFrom::kLog ? "recorded" : from == AirFrom::kStartAfterRest ? "start after a rest" : "fitted";
}

double ThermalRecording::start_c() const {
  const auto known =
      std::find_if(temperature_c.begin(), temperature_c.end(), [](double t) { return std::isfinite(t); });
  return known == temperature_c.end() ? 25.0 : *known;
}

ThermalRecording thermal_recording(const std::string& file, const MeasuredRun& run, const CellResponse& response,
                                   const RecordedTemperature& temperature) {
  constexpr double kTold_k = 1.0;  // an air within this of the start is said to be that of the start
  VOLTLAP_DEMAND(response.heat_w.size() == run.rows() && response.reversible_w.size() == run.rows());
  VOLTLAP_DEMAND(temperature.cell_c.size() == static_cast<std::size_t>(run.rows()));
  ThermalRecording out;
  out.file = file;
  out.temperature_c = temperature.cell_c;
  out.ambient_c = temperature.ambient_c;
  double at_c = temperature.start_c;
  for (Index row = 0; row < run.rows(); ++row) {
    const double reading = temperature.cell_c[static_cast<std::size_t>(row)];
    if (std::isfinite(reading)) at_c = reading;
    const double mean_a = 0.5 * (run.current_begin_a(row) + run.current_end_a(row));
    out.dt_s.push_back(run.is_reset(row) ? 0.0 : run.dt_s(row));
    out.heat_w.push_back(response.heat_w(row) - response.reversible_w(row));
    out.heat_per_entropy_w_k_per_v.push_back(-mean_a * (at_c + kZeroCelsius));
  }
  if (out.ambient_c.empty()) {
    const double within_k = air_within_k(run, temperature.cell_c);
    out.air = within_k <= kTold_k ? AirFrom::kStartAfterRest : AirFrom::kFitted;
    out.air_sd_k = out.air == AirFrom::kFitted ? kFreeAir_k : within_k;
    out.ambient_c.assign(out.rows(), temperature.start_c);
  }
  double last = temperature.start_c;
  for (double& ambient : out.ambient_c) last = ambient = std::isfinite(ambient) ? ambient : last;
  return out;
}

ThermalRecording part_of(const ThermalRecording& whole, std::size_t first, std::size_t last) {
  VOLTLAP_DEMAND(first <= last && last <= whole.rows());
  ThermalRecording out = whole;
  for (auto* column : {&out.dt_s, &out.heat_w, &out.heat_per_entropy_w_k_per_v, &out.temperature_c, &out.ambient_c}) {
    if (column->empty()) continue;
    column->erase(column->begin() + static_cast<std::ptrdiff_t>(last), column->end());
    column->erase(column->begin(), column->begin() + static_cast<std::ptrdiff_t>(first));
  }
  return out;
}

}  // namespace voltlap::plant
