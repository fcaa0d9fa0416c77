// SPDX-License-Identifier: Apache-2.0
// The car that a replay's firmware is configured for, from --pack and --set.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// Of a recording of our own bus: the vehicle as it was driven.
[[nodiscard]] LoadedVehicle pack_of_own(const DataFolder& data, const std::string& pack,
                                        const std::vector<std::string>& settings);

}  // namespace voltlap::plant
