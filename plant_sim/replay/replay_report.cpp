// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/page/html_buckets.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {

std::string_view replay_page_files(std::string_view name);

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPointsMax = 6000;
constexpr std::array<std::string_view, 6> kScripts = {"series.js",         "time_charts.js",    "time_chart.js",
                                                      "chart_gestures.js", "elapsed_charts.js", "replay.js"};

/// Rows of a second run at the times of the first: the latest of each moment.
std::vector<ReplayRow> at_times_of(const std::vector<ReplayRow>& first, const std::vector<ReplayRow>& second) {
  constexpr double kSame_s = 1e-6;
  std::vector<ReplayRow> out;
  std::size_t next = 0;
  ReplayRow held;
  for (const ReplayRow& row : first) {
    while (next < second.size() && second[next].time_s <= row.time_s + kSame_s) held = second[next++];
    out.push_back(held);
  }
  return out;
}

/// A curve has a value everywhere: where none is known it goes on with the last one.
std::vector<double> filled(const std::vector<ReplayRow>& rows, double ReplayRow::*field, double factor) {
  std::vector<double> out;
  double last = kUnknown;
  for (const ReplayRow& row : rows) {
    if (std::isfinite(row.*field)) last = factor * row.*field;
    out.push_back(last);
  }
  const auto first = std::find_if(out.begin(), out.end(), [](double value) { return std::isfinite(value); });
  if (first == out.end()) return {};
  std::fill(out.begin(), first, *first);
  return out;
}

std::string charts_data(const ReplayResult& r) {
  struct Column {
    const char* name;
    double ReplayRow::*field;
    double resolution, factor;
  };
  static constexpr Column kColumns[] = {
      {"soc_pct", &ReplayRow::soc, 0.01, 100.0},
      {"logged_soc_pct", &ReplayRow::logged_soc, 0.01, 100.0},
      {"current_a", &ReplayRow::current_a, 0.1, 1.0},
      {"discharge_limit_a", &ReplayRow::discharge_limit_a, 0.1, 1.0},
      {"charge_limit_a", &ReplayRow::charge_limit_a, 0.1, -1.0},
      {"logged_discharge_limit_a", &ReplayRow::logged_discharge_limit_a, 0.1, 1.0},
      {"logged_charge_limit_a", &ReplayRow::logged_charge_limit_a, 0.1, -1.0},
      {"cell_min_v", &ReplayRow::cell_min_v, 5e-4, 1.0},
      {"cell_max_v", &ReplayRow::cell_max_v, 5e-4, 1.0},
      {"temperature_max_c", &ReplayRow::temperature_max_c, 0.1, 1.0}};
  std::vector<double> times, active;
  for (const ReplayRow& row : r.rows) {
    times.push_back(row.time_s);
    active.push_back(row.state == can::BmsState::kTsActive ? 1.0 : 0.0);
  }
  Json columns = Json::object();
  std::size_t points = 0;
  const auto buckets = growing_buckets(times, std::vector<bool>(times.size(), false), kPointsMax);
  const auto add = [&](const HtmlSeries& series) {
    columns[series.name()] = {{"resolution", series.resolution()}, {"deltas", series.base64()}};
    points = series.size();
  };
  add(bucket_times(buckets, times));
  add(bucket_extremes(buckets, "active", 1.0, active));
  for (const Column& column : kColumns) {
    const std::vector<double> values = filled(r.rows, column.field, column.factor);
    if (!values.empty()) add(bucket_extremes(buckets, column.name, column.resolution, values));
  }
  if (!r.second) return Json{{"points", points}, {"columns", columns}}.dump();
  const std::vector<ReplayRow> second = at_times_of(r.rows, r.second->rows);
  for (const Column& column : kColumns) {
    if (std::string_view(column.name).starts_with("logged")) continue;
    const std::vector<double> values = filled(second, column.field, column.factor);
    const std::string name = std::string("second_") + column.name;
    if (!values.empty()) add(bucket_extremes(buckets, name, column.resolution, values));
  }
  return Json{{"points", points}, {"columns", columns}, {"second", r.second->name}}.dump();
}

std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "–";
}

std::string tiles(const ReplayResult& r) {
  const std::string no_model = "no cell model";
  double lowest = kUnknown;
  for (const ReplayRow& row : r.rows) {
    if (row.state == can::BmsState::kTsActive) lowest = std::fmin(lowest, row.discharge_limit_a);
  }
  const auto opens = std::count_if(r.faults.begin(), r.faults.end(), [](const ReplayFault& f) { return f.opens; });
  std::string out;
  const std::string from = fmt::format("firmware; from {} %", number(100.0 * r.soc_start(), 1));
  out += html_tile("SOC at the end", number(100.0 * r.soc_end(), 1), "%", r.has_cell_model() ? from : no_model);
  out += html_tile("Logged SOC", number(100.0 * r.logged_soc_end(), 1), "%",
                   fmt::format("the log's own; from {} %", number(100.0 * r.logged_soc_start(), 1)));
  out += html_tile("Lowest discharge limit", number(lowest, 0), "A",
                   r.has_cell_model() ? "while the contactors are closed" : no_model);
  out += html_tile("Cells beyond a limit", r.has_cell_model() ? fmt::format("{}", r.violations.size()) : "–",
                   "stretches", r.has_cell_model() ? "by the log's own readings" : no_model);
  out += html_tile("Trips", fmt::format("{}", opens), "", fmt::format("{} faults in all", r.faults.size()));
  out += html_tile("Faster than the log", number(r.firmware_s / r.computed_s, 0), "times", "reading apart");
  return out;
}

std::string disagreement_rows(const ReplayResult& r) {
  std::string out;
  for (const Disagreement& d : r.disagreements) {
    out += fmt::format(
        "<tr><th scope=\"row\"><button type=\"button\" data-begin=\"{:.3f}\" data-end=\"{:.3f}\" title=\"Show this "
        "stretch in the charts\">{:.1f} to {:.1f}</button></th><td>{}</td><td>{}</td></tr>\n",
        d.begin_s, d.end_s, d.begin_s, d.end_s, html_text(d.what), html_text(d.decided_by));
  }
  return out.empty() ? "<tr><td colspan=\"3\">none</td></tr>\n" : out;
}

std::string fault_rows(const ReplayResult& r) {
  constexpr std::size_t kShown = 200;
  std::string out;
  for (std::size_t k = 0; k < r.faults.size() && k < kShown; ++k) {
    const ReplayFault& f = r.faults[k];
    out += html_row({fmt::format("{:.2f}", f.time_s), f.id, f.node, f.about, f.opens ? "open" : ""});
  }
  if (r.faults.size() > kShown) {
    out += html_row({"", fmt::format("and {} more", r.faults.size() - kShown), "", "", ""});
  }
  return out.empty() ? "<tr><td colspan=\"5\">none</td></tr>\n" : out;
}

std::string items(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += fmt::format("<li>{}</li>\n", html_text(text));
  return out;
}

std::string comparison_items(const ReplayResult& r) {
  if (!r.comparison) return "";
  const FrameComparison& c = *r.comparison;
  if (c.identical()) {
    return items({fmt::format("{} frames of the BMS and {} of the master controller were answered as recorded, byte "
                              "for byte.",
                              c.bms.same, c.master.same)});
  }
  std::string where = "the log has no frame of either";
  if (c.first) {
    where = fmt::format("first difference at {:.3f} s: {} of the {}, recorded {}, answered {}", c.first->time_s,
                        c.first->message, c.first->node, c.first->recorded, c.first->answered);
  }
  return items({fmt::format("{} of {} frames of the BMS and {} of {} of the master controller were answered as "
                            "recorded; {}",
                            c.bms.same, c.bms.recorded, c.master.same, c.master.recorded, where)});
}

/// What another firmware or other settings change, one row each.
std::string change_rows(const ReplayResult& r) {
  constexpr std::size_t kShown = 100;
  if (!r.second) return "";
  const std::vector<std::string>& changes = r.second->changes;
  std::string out;
  for (std::size_t k = 0; k < changes.size() && k < kShown; ++k) out += html_row({changes[k]});
  if (changes.size() > kShown) out += html_row({fmt::format("and {} more", changes.size() - kShown)});
  return out.empty() ? html_row({"nothing"}) : out;
}

std::string headline(const ReplayResult& r) {
  if (r.comparison && r.comparison->first) {
    return fmt::format("Not answered as recorded: the first difference is at {:.3f} s, {} of the {}",
                       r.comparison->first->time_s, r.comparison->first->message, r.comparison->first->node);
  }
  if (!r.never_ready.empty()) return fmt::format("The firmware never closed its contactors: {}", r.never_ready);
  if (r.comparison && r.comparison->identical()) return "The firmware answers this log byte for byte as it did then";
  if (r.disagreements.empty()) return "Firmware and log agree";
  std::string out = r.disagreements.front().what;
  out.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(out.front())));
  return out;
}

std::vector<std::string> notes(const ReplayResult& r) {
  std::vector<std::string> out = r.assumptions;
  for (const LogDefect& defect : r.defects) out.push_back(defect.text);
  out.insert(out.end(), r.notes.begin(), r.notes.end());
  if (out.empty()) out.emplace_back("Nothing.");
  return out;
}

}  // namespace

std::string replay_report(const ReplayResult& r, const std::string& version) {
  const bool agrees = r.never_ready.empty() && r.disagreements.empty() && (!r.comparison || r.comparison->identical());
  const std::size_t differences = r.disagreements.size() + (r.comparison && !r.comparison->identical() ? 1U : 0U);
  const auto name = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  const std::string log = name(r.log);
  const std::string facts =
      fmt::format("{}: {:.1f} s, {} cells; map {}; {}; voltlap {}", log, r.duration_s, r.cells, name(r.map),
                  r.has_cell_model() ? "pack " + name(r.pack) : "no cell model", version);
  const std::string frame_row =
      html_row({fmt::format("{}", r.frames.in_file), fmt::format("{}", r.frames.used),
                fmt::format("{}", r.frames.ignored), fmt::format("{}", r.frames.corrupt),
                fmt::format("{}", r.frames.stale)});
  return html_page(
      {.title = log + ", voltlap replay",
       .description = headline(r),
       .body = fill_template(html_asset("replay.html", replay_page_files),
                             {{"status_class", agrees ? "good" : "open"},
                              {"status", agrees ? "✓ Agrees" : fmt::format("Disagreements: {}", differences)},
                              {"headline", html_text(page_words(headline(r)))},
                              {"facts", html_text(facts)},
                              {"tiles", tiles(r)},
                              {"disagreement_rows", disagreement_rows(r)},
                              {"fault_rows", fault_rows(r)},
                              {"frame_rows", frame_row},
                              {"comparison", comparison_items(r)},
                              {"second_hidden", r.second ? "" : " hidden"},
                              {"second_since", r.second ? html_text(r.second->since) : ""},
                              {"change_rows", change_rows(r)},
                              {"notes", items(notes(r))}}),
       .scripts = {kScripts.begin(), kScripts.end()},
       .data = charts_data(r),
       .own = replay_page_files});
}

}  // namespace voltlap::plant
