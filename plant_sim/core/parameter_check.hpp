// SPDX-License-Identifier: Apache-2.0
// What a single row of the parameter table cannot say: values that must fit to each other.
#pragma once
#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// Throws InputError, with the place the value came from, when tables are not increasing or differ in length, limits
/// stand in the wrong order, or a word is none of its choices.
void check_consistency(const LoadedVehicle& vehicle);

/// The same for a cell file by itself: of `holder` only the cell is looked at.
void check_cell_consistency(const LoadedVehicle& holder);

}  // namespace voltlap::plant
