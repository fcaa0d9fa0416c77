// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_study.hpp"

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

KindError& kind_of(ValidationStudy& study, const FileValidation& file) {
  if (file.constant_current) return study.constant_current;
  return file.temperature == TemperatureKind::kFree ? study.variable_temperature : study.variable_current;
}

void add_to_kind(ValidationStudy& study, const FileValidation& file) {
  KindError& kind = kind_of(study, file);
  kind.error += file.error;
  kind.adjusted += {file.capacity.rms_v * file.capacity.rms_v * file.error.weight_s, file.error.weight_s};
  ++kind.files;
}

ThermalValidation thermal_of(const CellParameters& cell, const ValidationStudy& study) {
  std::vector<ThermalRecording> recordings;
  for (std::size_t k = 0; k < study.recordings.size(); ++k) {
    const PlacedRecording& placed = study.recordings[k];
    if (placed.temperature.cell_c.empty()) continue;
    recordings.push_back(thermal_recording(placed.log->path, placed.run, study.responses[k], placed.temperature));
  }
  if (recordings.empty()) {
    throw InputError("--thermal", "no recording with a temperature",
                     "a column temperature_c, or a role temperature_1", "Add one, or leave --thermal out");
  }
  return validate_thermal(cell, recordings);
}

}  // namespace

ValidationStudy study_validation(const CellParameters& cell, const std::vector<CellLog>& logs,
                                 const StudyOptions& options) {
  const auto progress = [&](const std::string& what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  VOLTLAP_DEMAND(!logs.empty() && options.pack_cells >= 0);
  const CellModel model(cell);
  ValidationStudy out;
  std::vector<CapacityAdjustment> capacities;
  for (const CellLog& log : logs) {
    progress(log.path, static_cast<double>(out.files.size()) / static_cast<double>(logs.size()));
    out.recordings.push_back(place_recording(model, log, options.validation));
    out.responses.push_back(respond(model, out.recordings.back().run, out.recordings.back().temperature));
    out.files.push_back(validate(model, out.recordings.back(), out.responses.back()));
    capacities.push_back(out.files.back().capacity);
    add_to_kind(out, out.files.back());
  }
  VOLTLAP_DEMAND(out.files.size() == logs.size() && out.responses.size() == logs.size());
  if (options.reductions) {
    progress("reductions", 1.0);
    out.reductions = reductions(cell, out.recordings);
  }
  if (options.sensitivity) {
    progress("sensitivity", 1.0);
    out.tables = table_sensitivities(cell);
    out.errors = error_sensitivities(cell, out.recordings, capacities);
  }
  if (options.thermal) {
    progress("thermal model", 1.0);
    out.thermal = thermal_of(cell, out);
  }
  if (options.pack_cells > 0) {
    progress("pack", 1.0);
    out.pack = compare_pack(cell, out.recordings.front(), options.pack_cells);
  }
  return out;
}

}  // namespace voltlap::plant
