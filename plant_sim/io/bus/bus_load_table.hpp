// SPDX-License-Identifier: Apache-2.0
// The bus load of a run as text for the terminal, the largest share first. Messages that are numbered parts of one,
// CellVoltages_00 and the following, are one row.
#pragma once
#include <string>

#include "io/bus/bus_load.hpp"

namespace voltlap::plant {

/// Name of a message of the car's DBC files; "-" for one that is not in them.
[[nodiscard]] std::string message_name(std::uint32_t id);
/// 0x036, or 0x18FF0001 for a 29-bit identifier.
[[nodiscard]] std::string id_text(std::uint32_t id);

/// Several lines, with a final newline.
[[nodiscard]] std::string bus_load_table(const BusLoadResult& load);

}  // namespace voltlap::plant
