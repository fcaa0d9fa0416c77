// SPDX-License-Identifier: Apache-2.0
// Less current when the motor or the inverter is hot.
#pragma once
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

/// 1'000'000 below `start`, 0 from `end` on, straight between; `unknown` when the temperature is not known.
[[nodiscard]] Ratio temperature_share(const Sample<Temperature>& temperature, Temperature start, Temperature end,
                                      Ratio unknown);

/// Largest driving current at this motor speed: all of it up to 98 % of the highest, none from the highest on, straight
/// between. A speed that is not known lowers nothing here: it is taken as the highest where power is reckoned.
[[nodiscard]] Current speed_ceiling(const Config& config, const Input& input);

/// Largest phase current that the hotter of motor and inverter allows, in either direction.
[[nodiscard]] Current temperature_ceiling(const Config& config, const Input& input);

}  // namespace voltlap::master
