// SPDX-License-Identifier: Apache-2.0
// A comparison of runs as one HTML file. html/compare.html is its order, html/compare.js draws the charts.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_series.hpp"
#include "race/report/distance_trace.hpp"
#include "race/report/endurance_report_body.hpp"
#include "race/report/run_comparison.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

/// Of html/, in the order in which they need each other.
constexpr std::array<std::string_view, 5> kScripts = {"series.js", "time_charts.js", "time_chart.js",
                                                      "chart_gestures.js", "compare.js"};
constexpr double kDeltaStep_s = 0.001, kSameEnd_m = 0.1;

Json packed(const std::string& name, double resolution, const std::vector<double>& values) {
  HtmlSeries series(name, resolution);
  for (const double value : values) series.add(value);
  return {{"resolution", resolution}, {"deltas", series.base64()}, {"samples", values.size()}};
}

Json run_data(const RunComparison& comparison, std::size_t r) {
  const ComparedRun& run = comparison.runs[r];
  Json columns = Json::object();
  for (std::size_t c = 0; c < run.trace.size(); ++c) {
    const TraceChannel& channel = trace_channels()[c];
    columns[channel.name] = packed(channel.name, std::pow(10.0, -channel.digits), run.trace[c]);
  }
  columns["delta_s"] = packed("delta_s", kDeltaStep_s, comparison.delta_s[r]);
  return {{"name", run_letter(r) + " " + comparison.names[r]}, {"columns", columns}};
}

std::string data(const RunComparison& comparison) {
  Json runs = Json::array();
  int laps = 0;
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) {
    runs.push_back(run_data(comparison, r));
    laps = std::max(laps, comparison.runs[r].laps_asked);
  }
  // Laps from rest are counted by the clock: they have no place on the course.
  const bool flying = std::all_of(comparison.runs.begin(), comparison.runs.end(),
                                  [](const ComparedRun& run) { return run.lap_start == "flying"; });
  const std::optional<double>& course = comparison.runs[0].course_length_m;
  const Json length = flying && course ? Json(*course) : Json();
  const Json json = {{"runs", runs}, {"lap_m", length}, {"laps", length.is_null() ? 0 : laps}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string head_cells(const RunComparison& comparison, bool differences) {
  std::string out;
  const auto cell = [&](const std::string& text) { out += "<th scope=\"col\">" + html_text(text) + "</th>"; };
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) cell(run_letter(r));
  for (std::size_t r = 1; differences && r < comparison.runs.size(); ++r) cell(run_letter(r) + " − A");
  return out;
}

std::string minus_sign(std::string number) {
  if (number.size() > 1 && number[0] == '-') number.replace(0, 1, "−");
  return number;
}

std::string result_rows(const std::vector<ResultRow>& rows, const std::string& prefix = {}) {
  std::string out;
  for (const ResultRow& row : rows) {
    out += fmt::format("<tr><th scope=\"row\">{}{}</th>", html_text(prefix + row.name),
                       row.unit.empty() ? "" : ", " + html_text(row.unit));
    for (const auto& value : row.values) out += "<td>" + minus_sign(value_words(row, value)) + "</td>";
    for (std::size_t r = 1; r < row.values.size(); ++r) {
      out += "<td>" + minus_sign(value_words(row, difference(row, r), true)) + "</td>";
    }
    out += "</tr>\n";
  }
  return out;
}

std::string input_rows(const RunComparison& comparison) {
  std::string out;
  for (const InputDifference& input : comparison.inputs) {
    out += fmt::format("<tr><th scope=\"row\"><code>{}</code></th><td>{}</td>", html_text(input.key),
                       html_text(input.unit));
    for (const std::string& value : input.values) out += "<td class=\"value\">" + html_text(value) + "</td>";
    out += "</tr>\n";
  }
  if (!out.empty()) return out;
  return fmt::format("<tr><td colspan=\"{}\">No input differs.</td></tr>\n", 2 + comparison.runs.size());
}

std::string run_items(const RunComparison& comparison) {
  std::string out;
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) {
    const ComparedRun& run = comparison.runs[r];
    out += fmt::format("<li{}><span class=\"key\" style=\"--key: var(--run-{})\"></span><b>{} {}</b> {}</li>\n",
                       run.finished ? "" : " class=\"failed\"", r + 1, run_letter(r),
                       html_text(comparison.names[r]), html_text(run_words(run)));
  }
  return out;
}

/// Who was ahead, where both had driven; runs that ended otherwise than the first say so.
std::string sentence(const RunComparison& comparison) {
  const ComparedRun& first = comparison.runs[0];
  std::string out = first.finished ? "" : comparison.names[0] + " did not finish. ";
  for (std::size_t r = 1; r < comparison.runs.size(); ++r) {
    const ComparedRun& run = comparison.runs[r];
    const std::vector<double>& delta = comparison.delta_s[r];
    if (r > 1) out += " ";
    out += comparison.names[r];
    if (!run.finished) out += " did not finish; it";
    if (delta.empty()) {
      out += " shares no metre with the first.";
      continue;
    }
    const bool same_end = std::abs(run.trace[0].back() - first.trace[0].back()) < kSameEnd_m;
    const std::string where = run.finished && first.finished && same_end
                                  ? "at the finish"
                                  : fmt::format("after {:.2f} km", run.trace[0][delta.size() - 1] / 1000.0);
    out += fmt::format(" was {:.1f} s {} {} {}.", std::abs(delta.back()), delta.back() < 0.0 ? "ahead of" : "behind",
                       comparison.names[0], where);
  }
  return out;
}

}  // namespace

std::string comparison_page(const RunComparison& comparison) {
  VOLTLAP_DEMAND(comparison.runs.size() >= 2 && comparison.runs.size() <= kRunsMax);
  const std::string words = sentence(comparison), head = head_cells(comparison, true);
  const std::string limits = comparison.limits.empty() ? "" : result_rows(comparison.limits, "held back by ");
  const std::string body =
      fill_template(html_asset("compare.html", endurance_page_files),
                    {{"headline", html_text(words)},
                     {"runs", run_items(comparison)},
                     {"input_head", head_cells(comparison, false)},
                     {"head", head},
                     {"input_rows", input_rows(comparison)},
                     {"result_rows", result_rows(comparison.results) + limits},
                     {"lap_rows", result_rows(comparison.lap_times)},
                     {"energy_rows", result_rows(comparison.lap_energies)}});
  return html_page({.title = comparison.runs[0].course + ", voltlap compare",
                    .description = words,
                    .body = body,
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = data(comparison),
                    .own = endurance_page_files});
}

}  // namespace voltlap::plant
