// SPDX-License-Identifier: Apache-2.0
// A validation for people: each file, then the tables of the study.
#pragma once
#include <string>

#include "learn/validate/study_tables.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string file_text(const FileValidation& file);
[[nodiscard]] std::string study_text(const CellParameters& cell, const ValidationStudy& study);

/// "variable current, temperature held"
[[nodiscard]] std::string kind_name(const FileValidation& file);
/// How warm the model got where no temperature was recorded; empty where one was.
[[nodiscard]] std::string simulated_text(const FileValidation& file);
/// "above 80 %", "50 to 80 %"
[[nodiscard]] std::string band_name(const SocBand& band);

}  // namespace voltlap::plant
