// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/bench_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/demand.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "learn/bench/plan_rows.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPointsMax = 3000;
constexpr std::array<std::string_view, 5> kScripts = {"series.js", "time_charts.js", "time_chart.js",
                                                      "chart_gestures.js", "bench.js"};

std::string sentence(const Campaign& campaign, const Forecast& forecast, const std::vector<TestResult>& results) {
  double seconds = 0.0;
  for (const TestResult& result : results) seconds += result.summary.duration_s;
  const std::string tests =
      fmt::format("{} test{} of plan {}", forecast.tests.size(), forecast.tests.size() == 1 ? "" : "s",
                  campaign.plan().name);
  if (results.empty()) return fmt::format("{} would take {} on the bench", tests, hours_text(forecast.bench_s));
  return fmt::format("{} took {} on the bench, {} were forecast", tests, hours_text(seconds),
                     hours_text(forecast.bench_s));
}

std::string tiles(const Campaign& campaign, const Forecast& forecast) {
  const Coverage& map = forecast.coverage;
  std::string out;
  out += html_tile("Tests", fmt::format("{}", forecast.tests.size()), "",
                   fmt::format("{} cells in series, {}", campaign.plan().cells.count, campaign.cell().name));
  out += html_tile("On the bench", fmt::format("{:.1f}", forecast.bench_s / 3600.0), "h",
                   fmt::format("forecast; a run may differ by {:.0f} %", 100.0 * kForecastMargin));
  out += html_tile("In the calendar", fmt::format("{:.1f}", forecast.calendar_s / 86400.0), "days",
                   fmt::format("with {:.0f} h of charge and rest between", campaign.plan().test.pause_h));
  out += html_tile("Breakpoints visited", fmt::format("{}", map.visited()), fmt::format("of {}", map.nodes()),
                   "of the cell's tables, with a second of load or more");
  out += html_tile("Rests", fmt::format("{}", forecast.rests.count), "",
                   fmt::format("{:.1f} to {:.1f} min", forecast.rests.shortest_s / 60.0,
                               forecast.rests.longest_s / 60.0));
  out += html_tile(fmt::format("Shorter than tau{}", forecast.rests.taus.size()),
                   fmt::format("{}", forecast.rests.shorter_than_last_tau), "rests",
                   "they show only a part of the slow branch");
  return out;
}

std::string test_rows(const Forecast& forecast, const std::vector<TestResult>& results) {
  std::string out;
  for (std::size_t i = 0; i < forecast.tests.size(); ++i) {
    const TestForecast& planned = forecast.tests[i];
    const TestForecast& t = results.empty() ? planned : results[i].summary;
    const double off = 100.0 * (t.duration_s / planned.duration_s - 1.0);
    const std::string by = t.end == TestEnd::kProgram || results.empty()
                               ? end_name(t.end)
                               : fmt::format("{}, cell {}", end_name(t.end), results[i].end_cell);
    out += html_row({t.test.name, hours_text(t.duration_s), hours_text(planned.duration_s),
                     results.empty() ? "-" : fmt::format("{:+.1f}", off), fmt::format("{}", t.pulses),
                     fmt::format("{:.1f}", t.charge_ah),
                     fmt::format("{:.0f} to {:.0f}", t.current_min_a, t.current_max_a),
                     fmt::format("{:.3f}", t.lowest_v), fmt::format("{:.0f} to {:.0f}", t.coldest_c, t.hottest_c), by,
                     t.test.load});
  }
  return out;
}

/// Colour of a number of seconds, by its logarithm up to a thousand.
std::string heat_cell(double seconds) {
  if (seconds < 0.5) return "<td class=\"never\">–</td>";
  const double heat = 0.06 + 0.44 * std::clamp(std::log10(seconds) / 3.0, 0.0, 1.0);
  return fmt::format("<td style=\"--heat:{:.0f}%\">{:.0f}</td>", 100.0 * heat, seconds);
}

std::string coverage_rows(const Coverage& map, bool rest) {
  std::string out;
  for (std::size_t t = 0; t < map.temperature_c().size(); ++t) {
    for (std::size_t c = 0; c < map.current_a().size(); ++c) {
      std::string cells;
      for (std::size_t s = 0; s < map.soc().size(); ++s)
        cells += heat_cell(rest ? map.rest_s(s, t, c) : map.load_s(s, t, c));
      out += fmt::format("<tr><th scope=\"row\">{} °C, {} A</th>{}</tr>\n", map.temperature_c()[t],
                         map.current_a()[c], cells);
    }
  }
  return out;
}

std::string coverage_head(const Coverage& map) {
  std::string out;
  for (const double soc : map.soc()) out += fmt::format("<th scope=\"col\">{:.3g}</th>", soc);
  return out;
}

std::string rests_sentence(const RestSummary& rests, double row_s) {
  if (rests.count == 0) return "No rest follows a load: no time constant can be seen.";
  return fmt::format(
      "The {} rests after loads (median {:.1f} min) show time constants from about {:.2g} s, two rows, to {:.0f} s, "
      "the longest rest. There the cell's {}; {} rests end "
      "before the slow branch has lost 63 %.",
      rests.count, rests.median_s / 60.0, 2.0 * row_s, rests.longest_s, taus_text(rests),
      rests.shorter_than_last_tau);
}

std::string plan_rows_html(const BenchPlan& plan) {
  BenchPlan copy = plan;
  std::string out;
  for (const PlanRow& row : plan_rows()) {
    if (row.kinds.find(plan.kind) == std::string_view::npos) continue;
    const Json value = std::visit([&](auto access) { return Json(access(copy)); }, row.access);
    const bool is_word = row.unit.find('|') != std::string_view::npos;
    out += fmt::format(
        "<tr><th scope=\"row\"><code>{}</code><small>{}</small></th><td class=\"value\">{}</td><td>{}</td></tr>\n",
        html_text(row.key), html_text(row.meaning), html_text(value.dump()), is_word ? "" : html_text(row.unit));
  }
  return out;
}

}  // namespace

double rise_at_end(const BenchRecord& record, const BenchPhase& rest) {
  constexpr double kHalf = 60.0;  // s
  VOLTLAP_DEMAND(rest.end_s >= rest.begin_s);
  const auto row_at = [&](double time) {
    return std::lower_bound(record.time_s.begin(), record.time_s.end(), time) - record.time_s.begin();
  };
  const auto a = row_at(std::max(rest.begin_s, rest.end_s - 2.0 * kHalf)),
             b = row_at(std::max(rest.begin_s, rest.end_s - kHalf)), c = row_at(rest.end_s);
  if (b <= a || c <= b) return 0.0;
  double most = 0.0;
  for (const CellRecord& cell : record.cells) {
    const auto mean = [&](auto from, auto to) {
      double sum = 0.0;
      for (auto row = from; row < to; ++row) sum += cell.voltage_v[static_cast<std::size_t>(row)];
      return sum / static_cast<double>(to - from);
    };
    const double rise = mean(b, c) - mean(a, b);
    if (std::abs(rise) > std::abs(most)) most = rise;
  }
  return most;
}

void BenchReport::add(const BenchRecord& record) {
  VOLTLAP_DEMAND(!record.cells.empty() && record.current_a.size() == record.time_s.size());
  Curves curves{record.test.name, record.duration_s(), record.cells.size(), {}, {}};
  const auto buckets = growing_buckets(record.time_s, current_steps(record.current_a), kPointsMax);
  curves.columns.push_back(bucket_times(buckets, record.time_s));
  curves.columns.push_back(bucket_extremes(buckets, "current_a", 0.1, record.current_a));
  curves.columns.push_back(bucket_extremes(buckets, "ambient_c", 0.1, record.ambient_c));
  for (std::size_t cell = 0; cell < record.cells.size(); ++cell) {
    const CellRecord& of = record.cells[cell];
    curves.columns.push_back(
        bucket_extremes(buckets, fmt::format("cell_{}_voltage_v", cell + 1), 2e-4, of.voltage_v));
    curves.columns.push_back(
        bucket_extremes(buckets, fmt::format("cell_{}_temperature_c", cell + 1), 0.05, of.temperature_c));
  }
  for (const BenchPhase& s : record.phases) {
    if (!s.load) curves.rests.push_back({s.end_s, s.soc, s.end_s - s.begin_s, rise_at_end(record, s)});
  }
  curves_.push_back(std::move(curves));
}

void BenchReport::finish(const Forecast& forecast, const std::vector<TestResult>& results,
                         const std::vector<std::string>& settings) {
  Json tests = Json::array();
  for (const Curves& curves : curves_) {
    Json columns = Json::object();
    for (const HtmlSeries& column : curves.columns)
      columns[column.name()] = {{"resolution", column.resolution()}, {"deltas", column.base64()}};
    tests.push_back({{"name", curves.name},
                     {"end_s", curves.end_s},
                     {"cells", curves.cells},
                     {"samples", curves.columns.front().size()},
                     {"columns", columns},
                     {"rests", curves.rests}});
  }
  const std::string what = sentence(campaign_, forecast, results), head = coverage_head(forecast.coverage);
  std::string set;
  for (const std::string& setting : settings) set += (set.empty() ? "" : " ") + setting;
  const Json data = {{"tests", tests}, {"rehearsal", results.empty()}};
  file_.write(html_page(
      {.title = campaign_.plan().name + ", voltlap bench-test",
       .description = what,
       .body = fill_template(
           html_asset("bench.html", bench_page_files),
           {{"status", results.empty() ? "Rehearsed" : "✓ Done"},
            {"headline", html_text(what)},
            {"facts", html_text(fmt::format("{}; cell {}, box {}, seed {}, voltlap {}",
                                            campaign_.plan().description, campaign_.cell().name,
                                            campaign_.plan().box.mode, campaign_.seed(), VOLTLAP_VERSION))},
            {"tiles", tiles(campaign_, forecast)},
            {"whose", results.empty() ? "Curves are the rehearsal's: one nominal cell, ideal instruments."
                                      : "Curves are what the instruments read."},
            {"test_rows", test_rows(forecast, results)},
            {"coverage_head", head},
            {"coverage_rows", coverage_rows(forecast.coverage, false)},
            {"rest_rows", coverage_rows(forecast.coverage, true)},
            {"rests", rests_sentence(forecast.rests, forecast.row_s)},
            {"plan_rows", plan_rows_html(campaign_.plan())},
            {"settings", html_fact("--set", set.empty() ? "nothing" : set)}}),
       .scripts = {kScripts.begin(), kScripts.end()},
       .data = data.dump(-1, ' ', false, Json::error_handler_t::replace),
       .own = bench_page_files}));
  file_.complete();
}

}  // namespace voltlap::plant
