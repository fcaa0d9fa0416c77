// SPDX-License-Identifier: Apache-2.0
// An identification for a person: files, what was found in them, choices, tables with their intervals.
#pragma once
#include <string>

#include "core/parameters.hpp"
#include "learn/identify/cell_identification.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string identification_text(const CellParameters& cell, const CellIdentification& identified,
                                              int cells_in_series);

}  // namespace voltlap::plant
