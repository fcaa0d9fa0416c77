// SPDX-License-Identifier: Apache-2.0
// Less current when the motor or the inverter is hot.
#pragma once
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

/// 1'000'000 below `start`, 0 from `end` on, straight between; 0 when the temperature is not known.
[[nodiscard]] Ratio temperature_share(const Sample<Temperature>& temperature, Temperature start, Temperature end);

/// Largest phase current that the hotter of motor and inverter allows, in either direction.
[[nodiscard]] Current temperature_ceiling(const Config& config, const Input& input);

}  // namespace voltlap::master
