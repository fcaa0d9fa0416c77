// SPDX-License-Identifier: Apache-2.0
// Everything that `voltlap validate` finds, as it is asked for.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "learn/validate/error_sensitivity.hpp"
#include "learn/validate/pack_comparison.hpp"
#include "learn/validate/reductions.hpp"
#include "learn/validate/table_sensitivity.hpp"
#include "learn/validate/thermal_validation.hpp"

namespace voltlap::plant {

struct StudyOptions {
  ValidationOptions validation;
  bool sensitivity = false, reductions = false, thermal = false;
  int pack_cells = 0;                                                      ///< 0: no comparison
  std::function<void(const std::string& what, double fraction)> progress;  ///< may be empty
};

/// Error of files of one kind together.
struct KindError {
  ErrorSum error, adjusted;
  int files = 0;
};

struct ValidationStudy {
  std::vector<FileValidation> files;
  std::vector<PlacedRecording> recordings;  ///< as many
  std::vector<CellResponse> responses;      ///< as many
  KindError constant_current, variable_current, variable_temperature;
  std::vector<TableSensitivity> tables;
  std::vector<ErrorSensitivity> errors;
  std::vector<Reduction> reductions;
  std::optional<ThermalValidation> thermal;
  std::optional<PackComparison> pack;
};

/// `logs` must outlive the result. Throws InputError for a recording without discharge, and for a thermal fit
/// without a temperature that changes.
[[nodiscard]] ValidationStudy study_validation(const CellParameters& cell, const std::vector<CellLog>& logs,
                                               const StudyOptions& options);

}  // namespace voltlap::plant
