// SPDX-License-Identifier: Apache-2.0
// The BMS's configuration as a C++ header that an image compiles: constant, in the firmware's integers, checked by
// static_assert.
#pragma once
#include <string>

#include "apps/firmware_config.hpp"

namespace voltlap::plant {

/// What the header says of itself.
struct HeaderSource {
  std::string version, command;  ///< the command line that makes it again
};

/// The whole header; the same configuration gives the same bytes. It defines voltlap::bms::kPackConfig.
[[nodiscard]] std::string firmware_header(const VehicleParameters& car, const bms::Config& config,
                                          const TableRounding& rounding, const HeaderSource& source);

/// How far the tables are from the cell file, in sentences of a line each.
[[nodiscard]] std::string rounding_text(const bms::Config& config, const TableRounding& rounding);

}  // namespace voltlap::plant
