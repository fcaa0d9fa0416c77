// SPDX-License-Identifier: Apache-2.0
// Cells that differ as those of a pack do, drawn from a seed.
#pragma once
#include <cstdint>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Each is drawn evenly from so much below to so much above.
struct DrawnSpread {
  double soc = 0.01;         ///< [1] of the charge at the begin
  double capacity = 0.01;    ///< [1] of the capacity
  double resistance = 0.05;  ///< [1] of all resistances
};

/// Gives every cell of the pack its own; the same seed gives the same cells. Charges are held within 0 and 1.
void draw_cells(const DrawnSpread& spread, std::uint64_t seed, VehicleParameters& car);

}  // namespace voltlap::plant
