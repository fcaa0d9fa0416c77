// SPDX-License-Identifier: Apache-2.0
// Readings of a slow channel that a logger writes again in every row until the next one comes.
#pragma once
#include <optional>

#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

/// The channel with each reading once, at the row in which it came; nothing for one that is read in every row. It is
/// slow when its value changes only in every so many rows, the same number for nearly all changes, 0.8 s or more, while
/// `live`, the pack's voltage or the current, moves between them.
[[nodiscard]] std::optional<Channel> without_repeats(const Channel& channel, const Channel& live);

}  // namespace voltlap::plant
