// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/explanation_report.hpp"

#include <array>

#include "explain/say/page/explanation_body.hpp"
#include "explain/say/page/explanation_charts.hpp"
#include "io/page/html_page.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<std::string_view, 6> kScripts = {"series.js",         "time_charts.js", "time_chart.js",
                                                      "chart_gestures.js", "soc_chart.js",   "explain.js"};

}  // namespace

std::string explanation_report(const ReportedExplanation& reported) {
  const Explanation& e = reported.explanation;
  return html_page({.title = std::string(name_of(e.verdict)) + ", voltlap explain",
                    .description = e.sentence,
                    .body = explanation_body(reported),
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = explanation_charts(e),
                    .own = explanation_page_files});
}

}  // namespace voltlap::plant
