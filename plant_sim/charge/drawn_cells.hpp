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

/// What is drawn of a spread that is asked for, both [1].
[[nodiscard]] double drawn_soc_spread(double asked, double soc);

/// Gives every cell of the pack its own; the same seed gives the same cells. Charges differ by no more than
/// drawn_soc_spread, so that none is below empty or above full and the mean stays.
void draw_cells(const DrawnSpread& spread, std::uint64_t seed, VehicleParameters& car);

}  // namespace voltlap::plant
