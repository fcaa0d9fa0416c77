// SPDX-License-Identifier: Apache-2.0
// Chosen signals of a recording over time as one HTML page. The recording is read twice: to see what its signals do,
// and to keep the points of those that are drawn; memory and page stay small however long it is.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/logs/plot/plotted_signals.hpp"

namespace voltlap::plant {

struct LogPlotRequest {
  std::string recording;                   ///< as it is called in the page
  std::vector<std::string> signals;        ///< names or patterns; none: those that move
  std::optional<double> from_s, to_s;      ///< since the recording's beginning
  std::string version, command;            ///< voltlap's own, and what makes the page again
  std::function<void(const std::string& what, double fraction)> progress = [](const std::string&, double) {};
};

struct LogPlot {
  std::string page;    ///< HTML
  std::string choice;  ///< which signals are drawn, in words
  std::size_t signals = 0, charts = 0;
  std::vector<std::string> notes;
};

/// Throws InputError for names that fit nothing and for a stretch without a sample.
[[nodiscard]] LogPlot plot_log(PlottedSignals& recorded, const LogPlotRequest& request);

}  // namespace voltlap::plant
