// SPDX-License-Identifier: Apache-2.0
// Accelerator and brake: position from two sensors, and every reason not to believe it.
#pragma once
#include "base/leaky_persistence.hpp"
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct PedalState {
  LeakyPersistence apps_disagree;
  LeakyPersistence apps_range;
  LeakyPersistence brake_sensor;
  // Computed by pedals_step.
  Ratio position{};            ///< 0 whenever a sensor cannot be believed
  Pressure brake_pressure{};   ///< the higher of the good circuits
  bool brake_pressed = false;
  bool released = false;       ///< both sensors good, in agreement and below the release level
  Faults latched{};            ///< stop power; cleared by a released pedal when their cause is gone
};

/// Travel of one sensor, 0 at `released` to 1'000'000 at `full`, clipped.
[[nodiscard]] Ratio apps_travel(const AppsChannel& channel, Potential voltage);

void pedals_step(const Config& config, const Input& input, PedalState& state);

}  // namespace voltlap::master
