// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/log_plot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/plot/chart_groups.hpp"
#include "io/logs/plot/log_plot_page.hpp"
#include "io/logs/plot/plot_choice.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kPointsOfPage = 600'000;  // some 3 MB
constexpr std::size_t kMostPoints = 40'000;     // of a signal

void check_stretch(const LogPlotRequest& request) {
  if (!request.from_s || !request.to_s || *request.to_s > *request.from_s) return;
  throw InputError("--to", fmt::format("{:g} s, which is not after --from {:g} s", *request.to_s, *request.from_s),
                   "a later time", "Correct one of them; both count from the recording's beginning");
}

bool is_inside(const LogPlotRequest& request, double time_s) {
  return (!request.from_s || time_s >= *request.from_s) && (!request.to_s || time_s <= *request.to_s);
}

std::vector<SignalCourse> courses_of(PlottedSignals& recorded, const LogPlotRequest& request) {
  std::vector<SignalCourse> out;
  recorded.read(
      [&](std::size_t signal, double time_s, double value) {
        if (signal >= out.size()) out.resize(signal + 1);
        if (is_inside(request, time_s)) out[signal].add(time_s, value);
      },
      [&](std::size_t frames) { request.progress(fmt::format("looking at {} frames", frames), 0.0); });
  out.resize(recorded.heads().size());
  const bool any = std::any_of(out.begin(), out.end(), [](const SignalCourse& one) { return one.samples() > 0; });
  if (any) return out;
  throw InputError(request.recording,
                   request.from_s || request.to_s
                       ? fmt::format("no value in that stretch of {:.3f} s", recorded.facts().duration_s)
                       : std::string("no value of any signal"),
                   "signals with values", "Check --from and --to, and that recording and DBC files belong together");
}

/// Traces of the chosen signals, in the order in which they were chosen.
std::vector<SignalTrace> trace(PlottedSignals& recorded, const LogPlotRequest& request,
                               const std::vector<std::size_t>& chosen, const std::vector<SignalCourse>& courses) {
  VOLTLAP_DEMAND(!chosen.empty());
  const std::size_t most = std::min(kMostPoints, kPointsOfPage / chosen.size());
  constexpr std::size_t kNotDrawn = ~std::size_t{0};
  std::vector<std::size_t> place(courses.size(), kNotDrawn);
  std::vector<SignalTrace> out;
  for (const std::size_t signal : chosen) {
    place[signal] = out.size();
    out.emplace_back(courses[signal], most);
  }
  const double frames_in_all = static_cast<double>(std::max<std::size_t>(recorded.facts().frames, 1));
  recorded.read(
      [&](std::size_t signal, double time_s, double value) {
        if (place[signal] != kNotDrawn && is_inside(request, time_s)) out[place[signal]].add(time_s, value);
      },
      [&](std::size_t frames) {
        request.progress("taking the points", static_cast<double>(frames) / frames_in_all);
      });
  for (SignalTrace& one : out) one.finish();
  return out;
}

}  // namespace

LogPlot plot_log(PlottedSignals& recorded, const LogPlotRequest& request) {
  check_stretch(request);
  const std::vector<SignalCourse> courses = courses_of(recorded, request);
  const std::vector<SignalHead>& heads = recorded.heads();
  const PlotChoice choice = request.signals.empty() ? signals_that_move(heads, courses)
                                                      : signals_named(request.signals, recorded, courses);
  const std::vector<SignalTrace> traces = trace(recorded, request, choice.signals, courses);
  const std::vector<ChartGroup> groups = chart_groups(choice.signals, heads, courses);
  LogPlot out;
  out.choice = choice.reason;
  out.signals = choice.signals.size();
  out.charts = groups.size();
  out.notes = recorded.facts().notes;
  out.page = log_plot_page({request, recorded.facts(), heads, courses, choice, traces, groups});
  return out;
}

}  // namespace voltlap::plant
