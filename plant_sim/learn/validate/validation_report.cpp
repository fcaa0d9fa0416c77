// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/validation_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/number_text.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "io/page/html_series.hpp"
#include "learn/identify/result/recording_error.hpp"
#include "learn/validate/validation_text.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;

constexpr std::array<std::string_view, 8> kScripts = {"series.js",          "time_charts.js",      "time_chart.js",
                                                      "chart_gestures.js",  "chart_reach.js",      "small_multiples.js",
                                                      "recording_charts.js", "validation.js"};

std::string file_name(const FileValidation& file) { return std::filesystem::path(file.file).filename().string(); }

double error_at(const ValidationStudy& study, std::size_t file, Index row) {
  return study.responses[file].voltage(row) - study.recordings[file].run.voltage_v(row);
}

/// One row of each bucket: where the error is largest, so that no spike is lost. None reaches over a gap; `begins` are
/// the places in the result behind one.
std::vector<Index> charted_rows(const ValidationStudy& study, std::size_t file, std::size_t most,
                                std::vector<std::size_t>& begins) {
  const PlacedRecording& placed = study.recordings[file];
  const Index rows = placed.run.rows(), bucket = 1 + rows / static_cast<Index>(most);
  std::vector<Index> out;
  Index first = 0;
  const auto error = [&](Index row) {
    return placed.run.weight_s(row) > 0.0 ? std::abs(error_at(study, file, row)) : 0.0;
  };
  for (Index row = 0; row < rows; ++row) {
    const bool anew = row > 0 && placed.log->gap[static_cast<std::size_t>(row)];
    if (anew) begins.push_back(out.size());
    if (anew || row == 0 || row - first >= bucket) {
      out.push_back(row);
      first = row;
    } else if (error(row) > error(out.back())) {
      out.back() = row;
    }
  }
  return out;
}

/// |error| [V] and weight of each row that counts.
std::vector<std::pair<double, double>> counted_sizes(const ValidationStudy& study,
                                                     const std::vector<std::size_t>& files) {
  std::vector<std::pair<double, double>> out;
  for (const std::size_t file : files) {
    const PlacedRecording& placed = study.recordings[file];
    for (Index row = 0; row < placed.run.rows(); ++row) {
      if (!placed.counts[static_cast<std::size_t>(row)]) continue;
      out.emplace_back(std::abs(error_at(study, file, row)), placed.run.weight_s(row));
    }
  }
  return out;
}

Json file_json(const ValidationStudy& study, std::size_t file, std::size_t most) {
  const PlacedRecording& placed = study.recordings[file];
  const CellResponse& response = study.responses[file];
  const bool measured = !placed.temperature.cell_c.empty();
  HtmlSeries series[] = {{"time_s", 0.01},  {"voltage_v", 1e-4},     {"model_v", 1e-4},
                         {"error_mv", 0.1}, {"current_a", 0.01},     {"soc", 1e-4},
                         {"counts", 1.0},   {"temperature_c", 0.01}, {"model_c", 0.01}};
  double voltage = 0.0, temperature = placed.temperature.start_c;
  std::vector<std::size_t> begins;
  const std::vector<Index> rows = charted_rows(study, file, most, begins);
  for (const Index row : rows) {
    const auto at = static_cast<std::size_t>(row);
    const bool known = std::isfinite(placed.log->voltage_v[at]);
    if (known || voltage == 0.0) voltage = known ? placed.log->voltage_v[at] : response.voltage(row);
    if (measured && std::isfinite(placed.temperature.cell_c[at])) temperature = placed.temperature.cell_c[at];
    const double values[] = {placed.run.time_s(row) - placed.run.time_s(0),
                             voltage,
                             response.voltage(row),
                             known ? 1e3 * (response.voltage(row) - voltage) : 0.0,
                             placed.run.current_a(row),
                             placed.run.soc(row),
                             placed.counts[at] ? 1.0 : 0.0,
                             temperature,
                             response.temperature(row)};
    for (std::size_t k = 0; k < std::size(series); ++k) series[k].add(values[k]);
  }
  Json columns = Json::object();
  for (const HtmlSeries& one : series)
    columns[one.name()] = {{"resolution", one.resolution()}, {"deltas", one.base64()}};
  const FileValidation& found = study.files[file];
  return {{"name", file_name(found)},
          {"note", kind_name(found)},
          {"end_s", placed.run.time_s(placed.run.rows() - 1) - placed.run.time_s(0)},
          {"rms_mv", 1e3 * found.rms_v},
          {"max_mv", 1e3 * found.max_error_v},
          {"most_mv", 1e3 * most_of(counted_sizes(study, {file}))},
          {"samples", rows.size()},
          {"begins", begins},
          {"has_temperature", measured},
          {"columns", columns}};
}

/// Indices of the recordings that are drawn, in their order.
std::vector<std::size_t> charted_files(const ValidationStudy& study) {
  std::vector<std::size_t> out(study.files.size());
  std::iota(out.begin(), out.end(), 0U);
  if (out.size() <= kChartedRecordings) return out;
  std::stable_sort(out.begin(), out.end(),
                   [&](std::size_t a, std::size_t b) { return study.files[a].rms_v > study.files[b].rms_v; });
  out.resize(kChartedRecordings);
  std::sort(out.begin(), out.end());
  return out;
}

std::string tile(const std::string& label, double volts, const std::string& note) {
  return html_tile(label, fmt::format("{:.1f}", 1e3 * volts), "mV", note);
}

std::string tiles(const ValidationStudy& study, const ErrorSum& all) {
  std::string out =
      tile("RMS", all.rms_v(),
           fmt::format("over {} recording{}", study.files.size(), study.files.size() == 1 ? "" : "s"));
  ErrorSum adjusted;
  std::array<SocBand, 5> bands = FileValidation{}.bands;
  const FileValidation* worst = &study.files.front();
  for (const FileValidation& file : study.files) {
    adjusted += {file.capacity.rms_v * file.capacity.rms_v * file.error.weight_s, file.error.weight_s};
    for (std::size_t k = 0; k < bands.size(); ++k) bands[k].error += file.bands[k].error;
    if (file.max_error_v > worst->max_error_v) worst = &file;
  }
  out += tile("RMS, capacities adjusted", adjusted.rms_v(), "each recording with the capacity that meets it best");
  out += tile("Largest error", worst->max_error_v, file_name(*worst));
  for (const SocBand& band : bands) {
    if (band.error.weight_s > 0.0) out += tile(band_name(band) + " SOC", band.error.rms_v(), "RMS");
  }
  return out;
}

std::string file_rows(const ValidationStudy& study) {
  std::string out;
  for (const FileValidation& v : study.files) {
    out += fmt::format(
        "<tr><th title=\"{}\" scope=\"row\">{}</th><td>{}</td><td>{:.1f}</td><td>{:.1f}</td><td>{:+.1f}</td>"
        "<td>{:.0f}</td><td>{:.1f}</td><td>{:+.2f}</td><td>{}</td></tr>\n",
        html_text(v.file), html_text(file_name(v)), html_text(kind_name(v)), 1e3 * v.rms_v,
        1e3 * v.rms_v_above_10_soc, shown(1e3 * v.bias_v, 1), 1e3 * v.max_error_v, 1e3 * v.capacity.rms_v,
        shown(v.capacity.by_ah, 2),
        v.temperature_rms_c ? fmt::format("{:.2f}", *v.temperature_rms_c) : "–");
  }
  return out;
}

/// What was found and mended in the recordings, a paragraph for each.
std::string remarks(const ValidationStudy& study) {
  std::string out;
  for (const FileValidation& v : study.files) {
    std::string text = fmt::format("SOC {:.3f} at the start, from {}; current {} (found from {})",
                                   shown(v.soc_start, 3), v.soc_start_from, name_of(v.hold), v.hold_from);
    if (v.voltage_lag_s > 0.0) {
      text += fmt::format("; its voltage trails its current by {:.2f} s: with that lag in the model {}",
                          v.voltage_lag_s, millivolts(v.rms_v_with_lag));
    }
    if (const std::string simulated = simulated_text(v); !simulated.empty()) text += "; " + simulated;
    for (const std::string& repair : v.repairs) text += "; " + repair;
    out += fmt::format("<p class=\"note\"><b>{}</b>: {}.</p>\n", html_text(file_name(v)),
                       html_text(page_words(text)));
  }
  return out;
}

std::string table_html(const StudyTable& table, std::size_t number) {
  std::string out = fmt::format(
      "<section aria-labelledby=\"table-{0}\">\n<h2 id=\"table-{0}\">{1}</h2>\n<div class=\"card\">\n<div "
      "class=\"scroll whole\" tabindex=\"0\" role=\"region\" aria-labelledby=\"table-{0}\">\n<table>\n<thead><tr>",
      number, html_text(table.title));
  for (const std::string& column : table.columns)
    out += fmt::format("<th scope=\"col\">{}</th>", html_text(column));
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    out += fmt::format("<tr><th scope=\"row\">{}</th>", html_text(page_words(row[0])));
    for (std::size_t k = 1; k < row.size(); ++k) out += fmt::format("<td>{}</td>", html_text(page_words(row[k])));
    out += "</tr>\n";
  }
  out += "</tbody>\n</table>\n</div>\n";
  for (const std::string& note : table.notes)
    out += fmt::format("<p class=\"note\">{}</p>\n", html_text(page_words(note)));
  return out + "</div>\n</section>\n";
}

}  // namespace

std::string validation_report(const CellParameters& cell, const ValidationStudy& study,
                              const ReportedValidation& reported) {
  ErrorSum all;
  for (const FileValidation& file : study.files) all += file.error;
  const double hours = all.weight_s / 3600.0;
  const std::size_t count = study.files.size();
  const std::string headline = fmt::format("{} predicts {} recording{} within {} RMS.", cell.name, count,
                                           count == 1 ? "" : "s", millivolts(all.rms_v()));
  const std::vector<std::size_t> charted = charted_files(study);
  double largest_v = 0.0;
  for (const std::size_t file : charted) largest_v = std::max(largest_v, study.files[file].max_error_v);
  Json data = {{"error", {{"rms_mv", 1e3 * all.rms_v()},
                          {"max_mv", 1e3 * largest_v},
                          {"most_mv", 1e3 * most_of(counted_sizes(study, charted))}}},
               {"files", Json::array()}};
  const std::size_t most = std::min(kChartedRows, kChartedRowsOfAll / charted.size());
  for (const std::size_t file : charted) data["files"].push_back(file_json(study, file, most));
  std::string tables;
  const std::vector<StudyTable> found = study_tables(cell, study);
  for (std::size_t k = 0; k < found.size(); ++k) tables += table_html(found[k], k + 1);
  const std::string note = charted.size() < count
                               ? fmt::format("Drawn are the {} recordings with the largest errors.", charted.size())
                               : std::string();
  const std::string body =
      fill_template(html_asset("validation.html", validation_page_files),
                    {{"status", "Validation"},
                     {"headline", html_text(headline)},
                     {"facts", html_text(fmt::format("{:.3f} Ah cell, {:.2f} h of discharge strokes, voltlap {}",
                                                     cell.capacity_ah, hours, reported.version))},
                     {"tiles", tiles(study, all)},
                     {"file_rows", file_rows(study)},
                     {"remarks", remarks(study)},
                     {"charts_note", note},
                     {"tables", tables},
                     {"run_facts", html_fact("command", reported.command) + html_fact("cell", cell.name) +
                                       html_fact("version", reported.version)}});
  return html_page({.title = cell.name + ", voltlap validate",
                    .description = headline,
                    .body = body,
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = data.dump(-1, ' ', false, Json::error_handler_t::replace),
                    .own = validation_page_files});
}

}  // namespace voltlap::plant
