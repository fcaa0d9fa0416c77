// SPDX-License-Identifier: Apache-2.0
// A round course ends where and as it began: what its segments miss is shared out over them.
#pragma once
#include <vector>

#include "race/track/track.hpp"

namespace voltlap::plant {

/// The least change of angles and lengths that closes the course: minimise sum (dtheta_k / 10 mrad)^2 + sum
/// (dL_k / 0.1 m)^2 so that end and start are one place and direction (Newton on the three conditions). Straights stay
/// straight. The segments as they were when that is not possible without changing one beyond recognition.
[[nodiscard]] std::vector<Segment> closed_segments(const std::vector<Segment>& segments);

}  // namespace voltlap::plant
