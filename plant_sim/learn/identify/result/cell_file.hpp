// SPDX-License-Identifier: Apache-2.0
// What an identification writes: a cell file as plant_sim/data/cells has them, and everything that was found as
// JSON.
#pragma once
#include <string>

#include "core/parameters.hpp"
#include "learn/identify/cell_identification.hpp"
#include "learn/identify/result/cell_body.hpp"

namespace voltlap::plant {

/// TOML that load_cell() reads; every number with its unit and where it is from.
[[nodiscard]] std::string cell_toml(const CellParameters& cell, const CellBody& body,
                                    const CellIdentification& identified);

/// All findings: files, notes, smoothness and order scores, each parameter with its 95 % interval and whether the
/// recordings excited it, and which of the cell's other numbers were told, measured or assumed.
[[nodiscard]] std::string identification_json(const CellParameters& cell, const CellBody& body,
                                              const CellIdentification& identified, const std::string& version);

}  // namespace voltlap::plant
