// SPDX-License-Identifier: Apache-2.0
// What the charts of an explanation's report draw, as JSON: residuals over time with no extreme lost, and their
// means over current, SOC, temperature and speed.
#pragma once
#include <string>

#include "explain/explanation.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string explanation_charts(const Explanation& explanation);

}  // namespace voltlap::plant
