// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/log_plot_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/demand.hpp"
#include "io/logs/plot/signal_unit.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "io/page/html_series.hpp"

namespace voltlap::plant {

std::string_view log_plot_page_files(std::string_view name);  // made by page_files.cmake

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 6> kScripts = {
    "series.js", "own_times.js", "time_charts.js", "time_chart.js", "chart_gestures.js", "log_plot.js"};
/// Steps of 2^30 at most: a difference of two values still is a number of 32 bits.
constexpr double kMostSteps = 1 << 30;

/// Names of page.css, told apart with any kind of colour vision.
constexpr std::array<std::string_view, 6> kColours = {"blue", "orange", "green", "purple", "limit-4", "limit-3"};

Json packed(const HtmlSeries& series) { return {{"resolution", series.resolution()}, {"deltas", series.base64()}}; }

double time_resolution(double span_s) {
  constexpr double kFine = 1e-4, kCoarse = 1e-3, kLong = 600.0;  // s
  return std::max(span_s < kLong ? kFine : kCoarse, span_s / kMostSteps);
}

double value_resolution(const SignalCourse& course) {
  // A value that has more decimals than that is drawn to a part in a million of its range.
  const double decimal = std::pow(10.0, -course.decimals());
  const double finest = course.range() * 1e-6;
  const double out = std::max({decimal, course.decimals() < 3 ? 0.0 : finest, course.range() / kMostSteps});
  return std::isfinite(out) && out > 0.0 ? out : 1.0;
}

/// Decimals that are worth reading in a range: four figures of it.
int decimals_worth(double low, double high, int decimals) {
  const double size = std::max(std::abs(low), std::abs(high));
  const int before = size >= 1.0 ? static_cast<int>(std::floor(std::log10(size))) + 1 : 0;
  return std::clamp(decimals, 0, std::max(0, 5 - before));
}

std::string value_text(double value, int decimals) {
  constexpr double kLarge = 1e7;
  if (std::abs(value) >= kLarge) return fmt::format("{:.4g}", value);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string value_text(const SignalCourse& course, double value) {
  return value_text(value, decimals_worth(course.low(), course.high(), course.decimals()));
}

/// A state's name with its number, any other value alone.
std::string value_text(const SignalHead& head, const SignalCourse& course, double value) {
  const auto state = head.states.find(value);
  const std::string number = value_text(course, value);
  return state == head.states.end() ? number : fmt::format("{} ({})", state->second, number);
}

std::string interval_text(double interval_s) {
  if (interval_s <= 0.0) return {};
  const bool is_short = interval_s < 1.0;
  const double number = is_short ? 1e3 * interval_s : interval_s;
  return fmt::format("{:.{}f} {}", number, number < 10.0 ? 1 : 0, is_short ? "ms" : "s");
}

/// The span of time that the charts show.
std::pair<double, double> stretch(const PlottedLog& log) {
  const double begin = std::max(log.request.from_s.value_or(0.0), 0.0);
  const double end = std::min(log.request.to_s.value_or(log.facts.duration_s), log.facts.duration_s);
  return {begin, std::max(end, begin + 1e-3)};
}

const SignalTrace& trace_of(const PlottedLog& log, std::size_t signal) {
  const auto& chosen = log.choice.signals;
  const auto at = std::find(chosen.begin(), chosen.end(), signal);
  VOLTLAP_DEMAND(at != chosen.end());
  return log.traces[static_cast<std::size_t>(at - chosen.begin())];
}

Json series_json(const PlottedLog& log, std::size_t signal, std::size_t place) {
  const SignalTrace& trace = trace_of(log, signal);
  const SignalCourse& course = log.courses[signal];
  VOLTLAP_DEMAND(trace.time_s().size() == trace.value().size());
  HtmlSeries times("time", time_resolution(course.last_s() - course.first_s())), begins("begins", 1.0);
  HtmlSeries values("value", value_resolution(course));
  for (std::size_t k = 0; k < trace.time_s().size(); ++k) {
    times.add(trace.time_s()[k] - course.first_s());
    values.add(trace.value()[k] - course.low());
  }
  Json states = Json::array();
  for (const auto& [value, name] : log.heads[signal].states) {
    if (value >= course.low() && value <= course.high()) states.push_back({value, name});
  }
  for (const std::size_t begin : trace.begins()) begins.add(static_cast<double>(begin));
  return {{"name", log.heads[signal].name},
          {"color", kColours[place % kColours.size()]},
          {"range", fmt::format("{} … {}", value_text(course, course.low()), value_text(course, course.high()))},
          {"stepped", course.is_stepped()},
          {"digits", decimals_worth(course.low(), course.high(), course.decimals())},
          {"states", states},
          {"points", times.size()},
          {"first_s", course.first_s()},
          {"low", course.low()},
          {"begins", trace.begins().size()},
          {"time", packed(times)},
          {"value", packed(values)},
          {"begin", packed(begins)}};
}

Json page_data(const PlottedLog& log) {
  const auto [begin, end] = stretch(log);
  Json charts = Json::array();
  for (const ChartGroup& group : log.groups) {
    Json series = Json::array();
    for (const std::size_t signal : group.signals) series.push_back(series_json(log, signal, series.size()));
    charts.push_back({{"title", group.title}, {"axis", group.quantity}, {"unit", group.unit}, {"series", series}});
  }
  return {{"begin_s", begin}, {"end_s", end}, {"charts", charts}};
}

std::string tiles(const PlottedLog& log, std::size_t remarks) {
  const auto [begin, end] = stretch(log);
  std::size_t heard = 0, gaps = 0;
  for (const SignalCourse& course : log.courses) heard += course.samples() > 0 ? 1U : 0U;
  for (const SignalTrace& trace : log.traces) gaps += trace.gaps();
  const bool whole = !log.request.from_s && !log.request.to_s;
  return html_tile("shown", fmt::format("{:.1f}", end - begin), "s",
                   whole ? "the whole recording" : fmt::format("of {:.1f} s", log.facts.duration_s)) +
         html_tile("recording", fmt::format("{}", log.facts.frames), "", log.facts.format) +
         html_tile("signals drawn", fmt::format("{}", log.choice.signals.size()), "",
                   fmt::format("of {} in the recording", heard)) +
         html_tile("charts", fmt::format("{}", log.groups.size()), "", "one for each unit and size") +
         html_tile("gaps", fmt::format("{}", gaps), "", "of drawn signals; no line crosses one") +
         html_tile("remarks", fmt::format("{}", remarks), "", "on the recording, below");
}

std::string signal_rows(const PlottedLog& log) {
  std::string out;
  const auto add = [&](std::size_t k, bool drawn) {
    const SignalCourse& s = log.courses[k];
    const SignalHead& head = log.heads[k];
    out += html_row({head.name, drawn ? "drawn" : "", signal_unit(head.unit).text, value_text(s, s.low()),
                     fmt::format("{:.3f}", s.low_at_s()), value_text(s, s.high()), fmt::format("{:.3f}", s.high_at_s()),
                     value_text(head, s, s.last()), fmt::format("{}", s.samples()), fmt::format("{}", s.changes()),
                     s.missing() > 0 ? fmt::format("{}", s.missing()) : "", interval_text(s.usual_interval_s()),
                     head.source});
  };
  std::vector<bool> drawn(log.heads.size(), false);
  for (const ChartGroup& group : log.groups) {
    for (const std::size_t k : group.signals) {
      add(k, true);
      drawn[k] = true;
    }
  }
  for (std::size_t k = 0; k < log.heads.size(); ++k) {
    if (!drawn[k] && log.courses[k].samples() > 0) add(k, false);
  }
  return out;
}

/// Defects, decisions and what the drawing left out, in words.
std::vector<std::string> notes(const PlottedLog& log) {
  constexpr std::size_t kNamed = 8;
  std::vector<std::string> out;
  for (std::size_t k = 0; k < log.traces.size(); ++k) {
    if (log.traces[k].bucket_s() == 0.0) continue;
    out.push_back(fmt::format("{}: too many samples for a page; the lowest and the highest value of every {:.3g} s are "
                              "drawn",
                              log.heads[log.choice.signals[k]].name, log.traces[k].bucket_s()));
  }
  std::vector<std::string> empty;
  for (std::size_t k = 0; k < log.heads.size(); ++k) {
    if (log.courses[k].samples() == 0 && log.courses[k].missing() > 0) empty.push_back(log.heads[k].name);
  }
  if (!empty.empty()) {
    const std::size_t count = empty.size();
    empty.resize(std::min(count, kNamed));
    out.push_back(fmt::format("{} signals were sent and had no measurement at any time, only codes that say so: {}{}",
                              count, fmt::join(empty, ", "), count > kNamed ? " ..." : ""));
  }
  out.insert(out.end(), log.facts.notes.begin(), log.facts.notes.end());
  return out;
}

std::string notes_html(const std::vector<std::string>& notes) {
  std::string out;
  for (const std::string& note : notes) out += "<li>" + html_text(note) + "</li>\n";
  return out.empty() ? "<li>none</li>\n" : out;
}

}  // namespace

std::string log_plot_page(const PlottedLog& log) {
  VOLTLAP_DEMAND(log.courses.size() == log.heads.size() && log.traces.size() == log.choice.signals.size());
  const std::string file = std::filesystem::path(log.request.recording).filename().string();
  const auto [begin, end] = stretch(log);
  const std::string headline =
      fmt::format("{}{}", file, log.facts.start.empty() ? "" : ", " + log.facts.start);
  const std::string facts = fmt::format("{:.3f} s to {:.3f} s. Drawn: {}.", begin, end, log.choice.reason);
  const std::vector<std::string> remarks = notes(log);
  const std::string data = page_data(log).dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::string body = fill_template(
      html_asset("log_plot.html", log_plot_page_files),
      {{"status", "Recording"},
       {"headline", html_text(headline)},
       {"facts", html_text(facts)},
       {"tiles", tiles(log, remarks.size())},
       {"signal_rows", signal_rows(log)},
       {"notes", notes_html(remarks)},
       {"run_facts", html_fact("command", log.request.command) + html_fact("recording", log.request.recording) +
                         html_fact("version", log.request.version)}});
  return html_page({.title = file + ", voltlap log plot",
                    .description = headline,
                    .body = body,
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = data,
                    .own = log_plot_page_files});
}

}  // namespace voltlap::plant
