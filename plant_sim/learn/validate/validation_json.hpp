// SPDX-License-Identifier: Apache-2.0
// A validation as JSON, and its error over time as a table.
#pragma once
#include <string>

#include "io/atomic_file.hpp"
#include "learn/validate/validation_study.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string validation_json(const CellParameters& cell, const ValidationStudy& study,
                                          const std::string& version);

/// `file` (from 1, in the order given), time, SOC, current, voltages, error and temperatures, row by row.
void write_error_table(AtomicFile& file, const CellParameters& cell, const ValidationStudy& study,
                       const std::string& version);

}  // namespace voltlap::plant
