// SPDX-License-Identifier: Apache-2.0
// The circuit of two branches that the BMS's filter reads: its parts over the charge, and what current and temperature
// make of them.
#pragma once
#include "bms/config.hpp"
#include "car/battery/cell_tables.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// At the SOC of the resistances, scaled to their whole: what the car says of that (key, cells in parallel, a planted
/// polarization) holds for each part.
void fill_branches(const VehicleParameters& car, const CellTables& tables, bms::Config& config);

}  // namespace voltlap::plant
