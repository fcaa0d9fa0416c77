// SPDX-License-Identifier: Apache-2.0
// Which signals of a recording are drawn: those that were asked for by name, or a few of each unit that move.
#pragma once
#include <string>
#include <vector>

#include "io/logs/plot/plotted_signals.hpp"
#include "io/logs/plot/signal_course.hpp"

namespace voltlap::plant {

struct PlotChoice {
  std::vector<std::size_t> signals;  ///< numbers, in the order in which they are drawn
  std::string reason;                ///< in words
};

/// Names or patterns with * and ?: "BmsStatus.PackVoltage", "PackVoltage", "*Temp*"; capitals do not count. Throws
/// InputError for one that fits nothing and for more signals than a page can show.
[[nodiscard]] PlotChoice signals_named(const std::vector<std::string>& patterns, const PlottedSignals& recorded,
                                         const std::vector<SignalCourse>& courses);

/// Those that say most, some of each quantity; without counters, checksums and what never changes.
[[nodiscard]] PlotChoice signals_that_move(const std::vector<SignalHead>& heads,
                                             const std::vector<SignalCourse>& courses);

}  // namespace voltlap::plant
