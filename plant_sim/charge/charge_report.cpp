// SPDX-License-Identifier: Apache-2.0
#include "charge/charge_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "charge/charge_text.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "io/page/html_series.hpp"

namespace voltlap::plant {

std::string_view charge_page_files(std::string_view name);  // made by page_files.cmake

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 6> kScripts = {"series.js",         "time_charts.js",    "time_chart.js",
                                                      "chart_gestures.js", "elapsed_charts.js", "charge.js"};

struct Column {
  const char* name;
  double (*value)(const ChargeSample&);
  double resolution;
};
constexpr Column kColumns[] = {
    {"time_s", [](const ChargeSample& s) { return s.time_s; }, 1.0},
    {"cell_min_v", [](const ChargeSample& s) { return s.cell_min_v; }, 1e-4},
    {"cell_max_v", [](const ChargeSample& s) { return s.cell_max_v; }, 1e-4},
    {"spread_mv", [](const ChargeSample& s) { return 1e3 * s.open_spread_v; }, 0.1},
    {"current_a", [](const ChargeSample& s) { return s.current_a; }, 0.01},
    {"asked_a", [](const ChargeSample& s) { return s.asked_a; }, 0.1},
    {"soc_min_pct", [](const ChargeSample& s) { return 100.0 * s.soc_min; }, 0.01},
    {"soc_max_pct", [](const ChargeSample& s) { return 100.0 * s.soc_max; }, 0.01},
    {"cells_bled", [](const ChargeSample& s) { return static_cast<double>(s.cells_bled); }, 1.0},
    {"temperature_c", [](const ChargeSample& s) { return s.temperature_c; }, 0.01}};

std::string data(const std::vector<ChargeSample>& samples) {
  Json columns = Json::object();
  for (const Column& column : kColumns) {
    HtmlSeries series(column.name, column.resolution);
    for (const ChargeSample& sample : samples) series.add(column.value(sample));
    columns[column.name] = {{"resolution", column.resolution}, {"deltas", series.base64()}};
  }
  return Json{{"points", samples.size()}, {"columns", columns}}.dump();
}

std::string tiles(const ChargeResult& r) {
  std::string out;
  out += html_tile("Time", duration_words(r.time_s), "", "of which bleeding " + duration_words(r.bleeding_s));
  out += html_tile("Charge", fmt::format("{:.1f}", 100.0 * r.end_soc), "%",
                   fmt::format("from {:.1f} %", 100.0 * r.begin_soc));
  out += html_tile("Highest cell", fmt::format("{:.4f}", r.highest_cell_v), "V",
                   fmt::format("at any time, cell {}", r.highest_cell + 1));
  out += html_tile("Spread at the end", fmt::format("{:.1f}", 1e3 * r.end_spread_v()), "mV",
                   fmt::format("open voltages; {:.1f} mV at the begin", 1e3 * r.begin_spread_v));
  out += html_tile("Into the pack", fmt::format("{:.2f}", r.charge_in_ah), "Ah",
                   fmt::format("{:.2f} kWh", 1e-3 * r.energy_in_wh));
  out += html_tile("Bled", fmt::format("{:.1f}", r.bled_wh), "Wh", fmt::format("{:.2f} Ah of all cells", r.bled_ah));
  return out;
}

std::string facts(const ChargeDescription& run, const ChargeResult& r) {
  std::string command = fmt::format("voltlap charge --vehicle {} --from-soc {:g} --to-soc {:g} --seed {}", run.vehicle,
                                    100.0 * run.from_soc, 100.0 * run.to_soc, run.seed);
  for (const std::string& setting : run.settings) command += " --set " + setting;
  return html_fact("Command", command) + html_fact("Version", VOLTLAP_VERSION) +
         html_fact("Frames on the bus", fmt::format("{}", r.frames)) +
         html_fact("Computed in", fmt::format("{:.1f} s", run.wall_s));
}

}  // namespace

std::string charge_page(const ChargeDescription& run, const ChargeResult& result,
                        const std::vector<ChargeSample>& samples) {
  const bool good = result.full || result.reached;
  const std::string words = fmt::format("After {} {}.", duration_words(result.time_s), ending_words(result));
  const std::string line = fmt::format("{}, {:g} to {:g} %, seed {}", run.vehicle, 100.0 * run.from_soc,
                                       100.0 * run.to_soc, run.seed);
  const std::string shown = tiles(result), repeated = facts(run, result);
  const std::string body = fill_template(html_asset("charge.html", charge_page_files),
                                         {{"status_class", good ? "good" : "bad"},
                                          {"status", good ? "Charged" : "Not charged"},
                                          {"headline", html_text(words)},
                                          {"facts", html_text(line)},
                                          {"tiles", shown},
                                          {"run_facts", repeated}});
  return html_page({.title = run.vehicle + ", voltlap charge",
                    .description = words,
                    .body = body,
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = data(samples),
                    .own = charge_page_files});
}

}  // namespace voltlap::plant
