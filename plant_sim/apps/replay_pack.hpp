// SPDX-License-Identifier: Apache-2.0
// The car that a replay's firmware is configured for, from --pack and --set.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

/// Of a recording of our own bus: the vehicle as it was driven.
[[nodiscard]] LoadedVehicle pack_of_own(const DataFolder& data, const std::string& pack,
                                        const std::vector<std::string>& settings);

/// Of a log by role: `pack` empty is a car without a model of its cells, whose checks against one are out
/// of reach. Throws InputError where cells of log and pack differ in number, and where neither says how many there are.
[[nodiscard]] LoadedVehicle pack_of_log(const DataFolder& data, const std::string& pack,
                                        const std::vector<std::string>& settings, const DriveLog& log);

}  // namespace voltlap::plant
