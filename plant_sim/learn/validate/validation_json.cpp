// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "learn/validate/study_tables.hpp"
#include "learn/validate/thermal_system.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;

Json number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

const char* name_of(TemperatureKind kind) {
  return kind == TemperatureKind::kHeld ? "held" : kind == TemperatureKind::kFree ? "free" : "not recorded";
}

Json file_json(const FileValidation& v) {
  Json out = {{"file", v.file},
              {"rms_v", v.rms_v},
              {"rms_v_above_10_soc", v.rms_v_above_10_soc},
              {"bias_v", v.bias_v},
              {"max_error_v", v.max_error_v},
              {"temperature_rms_c", number_or_null(v.temperature_rms_c)},
              {"temperature_start_c", v.simulated.start_c},
              {"temperature_start_from", v.simulated.start_from},
              {"temperature_model_highest_c", v.simulated.highest_c},
              {"ah", v.ah},
              {"soc_start", v.soc_start},
              {"soc_start_from", v.soc_start_from},
              {"constant_current", v.constant_current},
              {"temperature", name_of(v.temperature)},
              {"strokes", v.strokes},
              {"current_hold", voltlap::plant::name_of(v.hold)},
              {"current_hold_from", v.hold_from},
              {"voltage_lag_s", v.voltage_lag_s},
              {"rms_v_with_lag", v.rms_v_with_lag},
              {"capacity_adjustment_ah", v.capacity.by_ah},
              {"rms_v_capacity_adjusted", v.capacity.rms_v},
              {"capacity_told", !v.capacity.at_end},
              {"repairs", v.repairs}};
  for (const SocBand& band : v.bands) {
    out["rms_v_by_soc"].push_back(
        {{"soc_low", std::max(0.0, band.low)},
         {"soc_high", std::min(1.0, band.high)},
         {"rms_v", band.error.weight_s > 0.0 ? Json(band.error.rms_v()) : Json(nullptr)}});
  }
  return out;
}

Json kinds_json(const ValidationStudy& study) {
  Json out = Json::object();
  const std::pair<const char*, const KindError*> kinds[] = {{"constant_current", &study.constant_current},
                                                            {"variable_current", &study.variable_current},
                                                            {"variable_temperature", &study.variable_temperature}};
  for (const auto& [name, kind] : kinds) {
    if (kind->files == 0) continue;
    out[name] = {{"files", kind->files},
                 {"rms_v", kind->error.rms_v()},
                 {"rms_v_capacity_adjusted", kind->adjusted.rms_v()}};
  }
  return out;
}

Json sensitivity_json(const ValidationStudy& study) {
  Json out = Json::object();
  for (const TableSensitivity& one : study.tables) {
    out["tables"][name_of(one.parameter)] = {{"pct_per_ampere", number_or_null(one.pct_per_ampere)},
                                             {"pct_per_kelvin", number_or_null(one.pct_per_kelvin)}};
  }
  for (const ErrorSensitivity& one : study.errors) {
    out["rms_v"][one.parameter] = {{"plus_5_pct", one.rms_v[0]},
                                   {"plus_1_pct", one.rms_v[1]},
                                   {"nominal", one.rms_v[2]},
                                   {"minus_1_pct", one.rms_v[3]},
                                   {"minus_5_pct", one.rms_v[4]}};
  }
  return out;
}

Json class_json(const ThermalClass& one) {
  return {{"number", one.number},       {"unit", one.unit},   {"value", one.value},
          {"ci95", one.ci95},           {"other", one.other}, {"other_unit", one.other_unit},
          {"other_value", one.at},      {"slope", one.slope}};
}

Json thermal_json(const CellParameters& cell, const ThermalValidation& thermal) {
  const ThermalModel& fitted = thermal.fitted;
  Json out = {{"capacity_j_per_k", fitted.capacity_j_per_k},
              {"capacity_ci95_share", fitted.capacity_ci95},
              {"capacity_told", fitted.capacity_told},
              {"conductance_w_per_k", fitted.conductance_w_per_k},
              {"conductance_ci95_share", fitted.conductance_ci95},
              {"conductance_told", fitted.conductance_told},
              {"heat_capacity_j_per_kg_k", fitted.capacity_j_per_k / cell.mass_kg},
              {"convection_w_per_m2_k", fitted.conductance_w_per_k / cell.surface_area_m2},
              {"surface_lag_s", fitted.surface_lag_s},
              {"surface_lag_ci95_s", fitted.surface_lag_ci95_s},
              {"entropy_v_per_k", fitted.entropy_v_per_k},
              {"entropy_ci95_v_per_k", fitted.entropy_ci95_v_per_k},
              {"entropy_told", fitted.entropy_told},
              {"entropy_assumed_sd_v_per_k", kEntropySd_v_per_k},
              {"not_told_apart", Json::array()},
              {"cell_file_lines", cell_file_lines(cell, fitted)}};
  for (const ThermalClass& one : fitted.classes) out["not_told_apart"].push_back(class_json(one));
  for (const ThermalValidation::File& file : thermal.files) {
    out["files"].push_back({{"file", file.file},
                            {"rms_as_given_c", number_or_null(file.rms_as_given_c)},
                            {"rms_fitted_c", number_or_null(file.rms_fitted_c)},
                            {"ambient_recorded", file.air == AirFrom::kLog},
                            {"air_c", file.air_c},
                            {"air_ci95_k", file.air_ci95_k},
                            {"air_from", std::string(name_of(file.air))},
                            {"rms_held_out_c", number_or_null(file.rms_held_out_c)}});
  }
  return out;
}

Json difference_json(const PackDifference& d) {
  return {{"voltage_mean_v", d.voltage_mean_v},
          {"voltage_rms_v", d.voltage_rms_v},
          {"voltage_max_v", d.voltage_max_v},
          {"snr", number_or_null(d.snr)},
          {"soc_max", d.soc_max},
          {"weakest_cell_v", d.weakest_cell_v}};
}

/// An empty field where there is no number.
std::string field(const char* pattern, double value) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(pattern), value) : std::string();
}

}  // namespace

std::string validation_json(const CellParameters& cell, const ValidationStudy& study, const std::string& version) {
  Json out = {{"cell", cell.name}, {"version", version}, {"files", Json::array()}, {"kinds", kinds_json(study)}};
  for (const FileValidation& file : study.files) out["files"].push_back(file_json(file));
  for (const Reduction& reduction : study.reductions)
    out["reductions"].push_back({{"name", reduction_name(reduction)}, {"rms_v", reduction.rms_v}});
  if (!study.tables.empty()) out["sensitivity"] = sensitivity_json(study);
  if (study.thermal) out["thermal"] = thermal_json(cell, *study.thermal);
  if (study.pack) {
    out["pack"] = {{"cells", study.pack->cells},
                   {"equal", difference_json(study.pack->equal)},
                   {"differing", difference_json(study.pack->differing)}};
  }
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_error_table(AtomicFile& file, const CellParameters& cell, const ValidationStudy& study,
                       const std::string& version) {
  std::string text = fmt::format("# voltlap {} validate: cell {}\n", version, cell.name);
  for (std::size_t k = 0; k < study.files.size(); ++k)
    text += fmt::format("# file {}: {}\n", k + 1, study.files[k].file);
  text += "file,time_s,counts,soc,current_a,voltage_v,model_v,error_v,temperature_c,model_temperature_c\n";
  constexpr std::size_t kPiece = 1U << 16U;
  for (std::size_t k = 0; k < study.files.size(); ++k) {
    const PlacedRecording& placed = study.recordings[k];
    const MeasuredRun& run = placed.run;
    for (Index row = 0; row < run.rows(); ++row) {
      const auto at = static_cast<std::size_t>(row);
      const double voltage = placed.log->voltage_v[at], model = study.responses[k].voltage(row),
                   temperature = placed.temperature.cell_c.empty() ? std::nan("") : placed.temperature.cell_c[at];
      fmt::format_to(std::back_inserter(text), "{},{:.6f},{:d},{:.6f},{:.6g},{},{:.6f},{},{},{:.3f}\n", k + 1,
                     run.time_s(row), placed.counts[at], run.soc(row), run.current_a(row), field("{:.7g}", voltage),
                     model, field("{:.6f}", model - voltage), field("{:.5g}", temperature),
                     study.responses[k].temperature(row));
      if (text.size() < kPiece) continue;
      file.write(text);
      text.clear();
    }
  }
  file.write(text);
}

}  // namespace voltlap::plant
