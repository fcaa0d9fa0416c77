// SPDX-License-Identifier: Apache-2.0
// A comparison of runs for the terminal and as JSON.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "core/demand.hpp"
#include "race/report/distance_trace.hpp"
#include "race/report/run_comparison.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::string>;

/// Characters, not bytes: units have a degree sign.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Names to the left, numbers to the right, every column as wide as it must be.
std::string columns(const std::vector<Cells>& rows) {
  VOLTLAP_DEMAND(!rows.empty());
  std::vector<std::size_t> widths(rows[0].size(), 0);
  for (const Cells& row : rows) {
    VOLTLAP_DEMAND(row.size() == widths.size());
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  }
  std::string out;
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string space(widths[c] - width_of(row[c]), ' ');
      line += c < 2 ? "  " + row[c] + space : "  " + space + row[c];
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

Cells head(const RunComparison& comparison, const std::string& title, bool differences) {
  Cells out{title, "unit"};
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) out.push_back(run_letter(r));
  for (std::size_t r = 1; differences && r < comparison.runs.size(); ++r) out.push_back(run_letter(r) + "-A");
  return out;
}

std::string result_text(const RunComparison& comparison, const std::string& title, const std::vector<ResultRow>& rows) {
  if (rows.empty()) return {};
  std::vector<Cells> out{head(comparison, title, true)};
  for (const ResultRow& row : rows) {
    Cells& cells = out.emplace_back(Cells{row.name, row.unit});
    for (const auto& value : row.values) cells.push_back(value_words(row, value));
    for (std::size_t r = 1; r < row.values.size(); ++r) cells.push_back(value_words(row, difference(row, r), true));
  }
  return "\n" + columns(out);
}

std::string input_text(const RunComparison& comparison) {
  if (comparison.inputs.empty()) return "\n  inputs: no difference\n";
  constexpr std::size_t kShown = 28;
  std::vector<Cells> out{head(comparison, "inputs that differ", false)};
  for (const InputDifference& input : comparison.inputs) {
    Cells& cells = out.emplace_back(Cells{input.key, input.unit});
    for (const std::string& value : input.values) {
      cells.push_back(value.size() > kShown ? value.substr(0, kShown - 4) + " ..." : value);
    }
  }
  return "\n" + columns(out);
}

Json rows_json(const std::vector<ResultRow>& rows) {
  Json out = Json::array();
  const auto number = [](std::optional<double> value) { return value ? Json(*value) : Json(); };
  for (const ResultRow& row : rows) {
    Json values = Json::array(), differences = Json::array();
    for (std::size_t r = 0; r < row.values.size(); ++r) {
      values.push_back(number(row.values[r]));
      differences.push_back(number(difference(row, r)));
    }
    out.push_back({{"name", row.name}, {"unit", row.unit}, {"values", values}, {"differences", differences}});
  }
  return out;
}

}  // namespace

std::string comparison_text(const RunComparison& comparison) {
  std::string out;
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) {
    out += fmt::format("  {}  {}: {}\n", run_letter(r), comparison.runs[r].file, run_words(comparison.runs[r]));
  }
  return out + input_text(comparison) + result_text(comparison, "results", comparison.results) +
         result_text(comparison, "held back by", comparison.limits) +
         result_text(comparison, "lap times", comparison.lap_times);
}

std::string comparison_json(const RunComparison& comparison) {
  Json runs = Json::array(), inputs = Json::array(), delta = Json::array();
  for (std::size_t r = 0; r < comparison.runs.size(); ++r) {
    const ComparedRun& run = comparison.runs[r];
    runs.push_back({{"file", run.file}, {"status", run.finished ? "finished" : "failed"},
                    {"failure", run.finished ? Json() : Json(run.failure_cause)}, {"vehicle", run.vehicle},
                    {"course", run.course}, {"version", run.version}});
    const auto points = static_cast<std::ptrdiff_t>(comparison.delta_s[r].size());
    const std::vector<double>& at = run.trace[0];
    delta.push_back({{"distance_m", std::vector<double>(at.begin(), at.begin() + points)},
                     {"delta_s", comparison.delta_s[r]}});
  }
  for (const InputDifference& input : comparison.inputs) {
    inputs.push_back({{"key", input.key}, {"unit", input.unit}, {"values", input.values}});
  }
  const Json json = {{"runs", runs}, {"inputs", inputs}, {"results", rows_json(comparison.results)},
                     {"limit_active_s", rows_json(comparison.limits)}, {"lap_times", rows_json(comparison.lap_times)},
                     {"lap_energies", rows_json(comparison.lap_energies)}, {"delta", delta}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace voltlap::plant
