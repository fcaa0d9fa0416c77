// SPDX-License-Identifier: Apache-2.0
// The voltage of the bus as the pack's, for recordings that have no other.
#pragma once
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

/// The bus while it is the pack; otherwise, when no current flows, what the battery unit publishes, where it does.
[[nodiscard]] Channel pack_by_bus(const Channel& bus, const Channel* published);

}  // namespace voltlap::plant
