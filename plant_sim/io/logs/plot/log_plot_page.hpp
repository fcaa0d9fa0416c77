// SPDX-License-Identifier: Apache-2.0
// The page of chosen signals over time.
#pragma once
#include <string>
#include <vector>

#include "io/logs/plot/chart_groups.hpp"
#include "io/logs/plot/log_plot.hpp"
#include "io/logs/plot/plot_choice.hpp"
#include "io/logs/plot/signal_trace.hpp"

namespace voltlap::plant {

struct PlottedLog {
  const LogPlotRequest& request;
  const RecordingFacts& facts;
  const std::vector<SignalHead>& heads;
  const std::vector<SignalCourse>& courses;  ///< of each head
  const PlotChoice& choice;
  const std::vector<SignalTrace>& traces;    ///< of each chosen signal
  const std::vector<ChartGroup>& groups;
};

[[nodiscard]] std::string log_plot_page(const PlottedLog& log);

}  // namespace voltlap::plant
