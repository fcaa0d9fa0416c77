// SPDX-License-Identifier: Apache-2.0
// From the input that showed a difference to a short one: whole steps and whole kinds of frames are left out as long as
// some difference stays (delta debugging, Zeller and Hildebrandt 2002).
#pragma once
#include "run.hpp"

namespace same_firmware {

/// The first step after which the versions differ; steps.size() when they never do.
[[nodiscard]] std::size_t first_difference(const Versions& versions, const Difference& input);
/// Ends with the step that differs.
[[nodiscard]] Difference shrink(const Versions& versions, Difference input);

}  // namespace same_firmware
