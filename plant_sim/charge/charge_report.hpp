// SPDX-License-Identifier: Apache-2.0
// A charge as one HTML file: how it ended, the key numbers, curves over time, and what is needed to repeat it.
// html/charge.html is its order, html/charge.js draws the charts.
#pragma once
#include <string>
#include <vector>

#include "charge/charge_files.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string charge_page(const ChargeDescription& run, const ChargeResult& result,
                                      const std::vector<ChargeSample>& samples);

}  // namespace voltlap::plant
