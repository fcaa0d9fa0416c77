// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/identification_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/page/html_buckets.hpp"
#include "io/page/html_page.hpp"
#include "learn/identify/result/recording_error.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 9> kScripts = {
    "series.js",     "time_charts.js",     "time_chart.js",       "chart_gestures.js", "soc_chart.js",
    "chart_reach.js", "small_multiples.js", "recording_charts.js", "cell.js"};
constexpr std::size_t kSamplesOfAll = 90'000, kSamplesOfOne = 6'000;

std::vector<double> list_of(const Eigen::VectorXd& values, double offset = 0.0, double scale = 1.0) {
  std::vector<double> out(static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = scale * (values(static_cast<Index>(k)) - offset);
  return out;
}

/// The log that a recording's trace was made of: its gaps, and which rows have a voltage.
const CellLog* log_of(const std::vector<CellIdentification>& each, std::size_t group, const RecordingResult& file) {
  for (const CellIdentification& cell : each) {
    if (group >= cell.points.size()) continue;
    for (const CellLog& log : cell.points[group].logs) {
      if (log.path == file.path && static_cast<Index>(log.rows()) == file.trace.time_s.size()) return &log;
    }
  }
  return nullptr;
}

/// Rows without a voltage hold on to the one before.
std::vector<double> held(std::vector<double> values, const CellLog* log) {
  for (std::size_t row = 1; log != nullptr && row < values.size(); ++row)
    if (!std::isfinite(log->voltage_v[row])) values[row] = values[row - 1];
  return values;
}

std::vector<double> counted_rows(const RecordingResult& file) {
  std::vector<double> out;
  for (Index row = 0; row < file.trace.error_v.size(); ++row) out.push_back(counts(file, row) ? 1.0 : 0.0);
  return out;
}

/// The columns of a recording in few points, with where its lines begin anew.
Json samples_json(const RecordingResult& file, const CellLog* log, std::size_t samples_max) {
  const RecordingTrace& trace = file.trace;
  const std::vector<double> time = list_of(trace.time_s, trace.time_s(0)), current = list_of(trace.current_a);
  const std::vector<bool> begins = log == nullptr ? std::vector<bool>() : log->gap;
  const auto buckets = growing_buckets(time, current_steps(current), samples_max, begins);
  const Eigen::VectorXd model = trace.voltage_v + trace.error_v;
  const HtmlSeries series[] = {
      bucket_times(buckets, time),
      bucket_extremes(buckets, "measured_v", 1e-4, held(list_of(trace.voltage_v), log)),
      bucket_extremes(buckets, "model_v", 1e-4, list_of(model)),
      bucket_extremes(buckets, "error_mv", 0.02, held(list_of(trace.error_v, 0.0, 1e3), log)),
      bucket_extremes(buckets, "current_a", 0.01, current),
      bucket_extremes(buckets, "counts", 1.0, counted_rows(file))};
  Json columns = Json::object();
  for (const HtmlSeries& one : series)
    columns[one.name()] = {{"resolution", one.resolution()}, {"deltas", one.base64()}};
  return {{"samples", series[0].size()}, {"begins", bucket_begins(buckets, begins)}, {"columns", columns}};
}

/// Seconds of error in equal bins out to where 99.8 % lie; the rest is in the outer bins. Of the rows that count.
Json histogram(const RecordingResult& file) {
  constexpr int kBins = 61;
  const RecordingTrace& trace = file.trace;
  std::vector<double> sizes;
  for (Index row = 0; row < trace.error_v.size(); ++row)
    if (counts(file, row)) sizes.push_back(std::abs(trace.error_v(row)));
  if (sizes.empty()) sizes.push_back(0.0);
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(0.998 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double reach = std::max(1e-4, *at), width = 2.0 * reach / kBins;
  std::vector<double> seconds(kBins, 0.0);
  for (Index row = 0; row < trace.error_v.size(); ++row) {
    if (!counts(file, row)) continue;
    const double bin = std::floor((trace.error_v(row) + reach) / width);
    seconds[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += trace.weight_s(row);
  }
  return {{"low_mv", -1e3 * reach}, {"width_mv", 1e3 * width}, {"seconds", seconds}};
}

/// Mean and rms of the error by SOC, of the rows that count.
Json by_soc(const RecordingResult& file) {
  const RecordingTrace& trace = file.trace;
  constexpr int kBins = 50;
  std::vector<std::array<double, 3>> sums(kBins + 1, {0.0, 0.0, 0.0});
  for (Index row = 0; row < trace.soc.size(); ++row) {
    if (!counts(file, row)) continue;
    auto& [seconds, sum, square] =
        sums[static_cast<std::size_t>(std::clamp(std::round(trace.soc(row) * kBins), 0.0, double{kBins}))];
    seconds += trace.weight_s(row);
    sum += trace.weight_s(row) * trace.error_v(row);
    square += trace.weight_s(row) * trace.error_v(row) * trace.error_v(row);
  }
  Json out = {{"soc", Json::array()}, {"mean_mv", Json::array()}, {"rms_mv", Json::array()}};
  for (int bin = 0; bin <= kBins; ++bin) {
    const auto& [seconds, sum, square] = sums[static_cast<std::size_t>(bin)];
    if (seconds <= 0.0) continue;
    out["soc"].push_back(static_cast<double>(bin) / kBins);
    out["mean_mv"].push_back(1e3 * sum / seconds);
    out["rms_mv"].push_back(1e3 * std::sqrt(square / seconds));
  }
  return out;
}

Json recording_json(const RecordingResult& file, const CellLog* log, std::size_t samples_max) {
  constexpr double kMillivolts = 1e3;
  const RecordingTrace& trace = file.trace;
  const RecordingError error = error_of(file);
  Json out = {{"name", std::filesystem::path(file.path).filename().string()},
              {"end_s", trace.time_s(trace.time_s.size() - 1) - trace.time_s(0)},
              {"rms_mv", kMillivolts * error.rms_v},
              {"max_mv", kMillivolts * error.largest_v},
              {"most_mv", kMillivolts * error.most_v},
              {"histogram", histogram(file)},
              {"by_soc", by_soc(file)}};
  out.update(samples_json(file, log, samples_max));
  return out;
}

Json recordings(const ReportedCell& reported) {
  const std::vector<OperatingPoint>& points = reported.identified.points;
  std::size_t files = 0;
  for (const OperatingPoint& point : points) files += point.result.files.size();
  const std::size_t samples_max = std::min(kSamplesOfOne, kSamplesOfAll / files);
  Json out = Json::array();
  for (std::size_t group = 0; group < points.size(); ++group) {
    for (const RecordingResult& file : points[group].result.files)
      out.push_back(recording_json(file, log_of(reported.each, group, file), samples_max));
  }
  return out;
}

}  // namespace

std::string identification_report(const ReportedCell& reported, const std::string& version) {
  const Json found = Json::parse(reported.json);
  Json places = Json::array();
  for (const Json& test : found["tests"]) {
    places.push_back({{"temperature_c", test["temperature_c"]},
                      {"current_a", test["current_a"]},
                      {"parameters", test["parameters"]}});
  }
  const RecordingError error = error_of(reported.identified);
  const Json data = {{"recordings", recordings(reported)},
                     {"error", {{"rms_mv", 1e3 * error.rms_v},
                                {"max_mv", 1e3 * error.largest_v},
                                {"most_mv", 1e3 * error.most_v}}},
                     {"temperature_told", reported.identified.temperature_told},
                     {"places", places},
                     {"reference", reported.identified.reference}};
  return html_page({.title = reported.cell.name + ", voltlap identify",
                    .description = fmt::format("{}: {:.2f} Ah", reported.cell.name, reported.cell.capacity_ah),
                    .body = identification_report_body(reported, version),
                    .scripts = {kScripts.begin(), kScripts.end()},
                    .data = data.dump(-1, ' ', false, Json::error_handler_t::replace),
                    .own = cell_page_files});
}

}  // namespace voltlap::plant
