// SPDX-License-Identifier: Apache-2.0
// A configuration of the master controller as the C++ header that an image is built with, beside firmware_header.hpp.
#pragma once
#include <cstdint>
#include <string>

#include "apps/firmware_header.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

/// As of bms::Config.
[[nodiscard]] std::uint32_t configuration_number(const master::Config& config);

/// The whole header, every field of it; the same configuration gives the same bytes. It defines
/// voltlap::master::kMasterConfig.
[[nodiscard]] std::string master_header(const std::string& vehicle, const master::Config& config,
                                        const HeaderSource& source);

}  // namespace voltlap::plant
