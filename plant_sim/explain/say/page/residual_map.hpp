// SPDX-License-Identifier: Apache-2.0
// The residual map: RMS of every channel in every stretch of time over the channel's noise, as coloured tables.
#pragma once
#include <string>

#include "explain/explanation.hpp"

namespace voltlap::plant {

/// HTML; empty when nothing was compared. Of a group of cells or thermistors those that are farthest off are shown.
[[nodiscard]] std::string residual_map(const Explanation& explanation);

}  // namespace voltlap::plant
