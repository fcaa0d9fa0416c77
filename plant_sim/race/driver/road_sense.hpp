// SPDX-License-Identifier: Apache-2.0
// What a driver feels of the road: how far each pedal may go before tyres spin or lock.
#pragma once
#include "car/vehicle/longitudinal.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// A trace over time knows nothing of a road: then no pedal is held back, and nobody brakes for being too fast.
struct RoadSense {
  bool follows_road = false;
  double accelerator_most = 1.0, brake_most = 1.0;  ///< pedals, 0..1
  double coasting_mps2 = 0.0;  ///< acceleration with no pedal, below 0 on a level road
};

/// On a road, at a speed. A driver keeps a little below the edge that a calculation knows exactly.
[[nodiscard]] RoadSense feel_road(const VehicleParameters& car, const Road& road, double speed_mps);

}  // namespace voltlap::plant
