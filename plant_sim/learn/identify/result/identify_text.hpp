// SPDX-License-Identifier: Apache-2.0
// An identification for a person: what was told, measured and assumed, files, what was found in them, choices, tables
// with their intervals.
#pragma once
#include <string>

#include "core/parameters.hpp"
#include "learn/identify/cell_identification.hpp"
#include "learn/identify/result/cell_body.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string identification_text(const CellParameters& cell, const CellBody& body,
                                              const CellIdentification& identified, int cells_in_series);

}  // namespace voltlap::plant
