// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "car/battery/cell_thermal.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

std::optional<ThermalModel> fit_if_told(const std::vector<ThermalRecording>& recordings) {
  try {
    return fit_thermal(recordings);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

ThermalModel model_of(const CellParameters& cell) {
  const CellThermal thermal = thermal_of(cell);
  ThermalModel out;
  out.capacity_j_per_k = thermal.heat_capacity_j_per_k;
  out.conductance_w_per_k = thermal.cooling_w_per_k;
  out.surface_lag_s = thermal.surface_lag_s;
  out.entropy_v_per_k = cell.effects.entropy_v_per_k;
  return out;
}

/// In air of a known temperature; unchanged where the log has it.
ThermalRecording in_air(ThermalRecording recording, double air_c) {
  if (recording.air != AirFrom::kLog) recording.ambient_c.assign(recording.rows(), air_c);
  return recording;
}

/// RMS of a recording that the fit did not see.
std::optional<double> held_out(const std::vector<ThermalRecording>& recordings, std::size_t k) {
  const ThermalRecording& one = recordings[k];
  if (recordings.size() > 1) {
    std::vector<ThermalRecording> others = recordings;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const auto model = fit_if_told(others);
    return model ? thermal_rms_c(*model, one) : std::nullopt;
  }
  const std::size_t half = one.rows() / 2;
  const auto model = fit_if_told({part_of(one, 0, half)});
  return model ? thermal_rms_c(*model, in_air(one, model->air_c.front()), half) : std::nullopt;
}

}  // namespace

std::vector<double> thermal_response(const ThermalModel& model, const ThermalRecording& recording) {
  VOLTLAP_DEMAND(model.capacity_j_per_k > 0.0 && recording.rows() == recording.temperature_c.size());
  const CellThermal thermal{model.capacity_j_per_k, model.conductance_w_per_k, model.surface_lag_s};
  double t = recording.start_c(), surface = t;
  std::vector<double> out{t};
  for (std::size_t row = 1; row < recording.rows(); ++row) {
    const double dt = recording.dt_s[row], before = t;
    if (dt <= 0.0) {
      if (std::isfinite(recording.temperature_c[row])) t = surface = recording.temperature_c[row];
    } else {
      const double heat = recording.heat_w[row] + model.entropy_v_per_k * recording.heat_per_entropy(row);
      t = temperature_after(thermal, t, heat, recording.ambient_c[row - 1], dt, thermal.decay(dt));
      surface = surface_after(surface, before, t, model.surface_lag_s, dt);
    }
    out.push_back(surface);
  }
  return out;
}

std::optional<double> thermal_rms_c(const ThermalModel& model, const ThermalRecording& recording,
                                    std::size_t from_row) {
  const std::vector<double> t = thermal_response(model, recording);
  VOLTLAP_DEMAND(t.size() == recording.rows());
  double sum = 0.0, weight = 0.0;
  for (std::size_t row = from_row; row < t.size(); ++row) {
    const double e = t[row] - recording.temperature_c[row], dt = recording.dt_s[row];
    if (!std::isfinite(e)) continue;
    sum += dt * e * e;
    weight += dt;
  }
  return weight > 0.0 ? std::optional(std::sqrt(sum / weight)) : std::nullopt;
}

ThermalValidation validate_thermal(const CellParameters& cell, const std::vector<ThermalRecording>& recordings) {
  ThermalValidation out{fit_thermal(recordings), {}};
  const ThermalModel given = model_of(cell);
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const double air_c = out.fitted.air_c[k];
    const ThermalRecording one = in_air(recordings[k], air_c);
    out.files.push_back({one.file, thermal_rms_c(given, one), thermal_rms_c(out.fitted, one), one.air, air_c,
                         out.fitted.air_ci95_k[k], held_out(recordings, k)});
  }
  return out;
}

std::vector<std::string> cell_file_lines(const CellParameters& cell, const ThermalModel& model) {
  VOLTLAP_DEMAND(cell.mass_kg > 0.0 && cell.surface_area_m2 > 0.0);
  return {fmt::format("heat_capacity_j_per_kg_k = {:.6g}", model.capacity_j_per_k / cell.mass_kg),
          fmt::format("convection_w_per_m2_k = {:.6g}", model.conductance_w_per_k / cell.surface_area_m2),
          fmt::format("surface_lag_s = {:.6g}", model.surface_lag_s), "[effects]",
          fmt::format("entropy_v_per_k = {:.6g}", model.entropy_v_per_k)};
}

}  // namespace voltlap::plant
