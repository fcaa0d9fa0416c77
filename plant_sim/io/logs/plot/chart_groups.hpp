// SPDX-License-Identifier: Apache-2.0
// Signals that share a chart: of one unit, and of sizes that can be read on one axis.
#pragma once
#include <string>
#include <vector>

#include "io/logs/plot/plotted_signals.hpp"
#include "io/logs/plot/signal_course.hpp"

namespace voltlap::plant {

struct ChartGroup {
  std::string quantity, title;
  std::string unit;                  ///< as signal_unit gives it
  std::vector<std::size_t> signals;  ///< numbers
  int decimals = 0;                  ///< of its values as text
};

/// Every signal of `chosen` once.
[[nodiscard]] std::vector<ChartGroup> chart_groups(const std::vector<std::size_t>& chosen,
                                                   const std::vector<SignalHead>& heads,
                                                   const std::vector<SignalCourse>& courses);

}  // namespace voltlap::plant
