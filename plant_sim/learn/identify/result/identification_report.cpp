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

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 6> kScripts = {"series.js",         "time_charts.js", "time_chart.js",
                                                      "chart_gestures.js", "soc_chart.js",   "cell.js"};
constexpr std::size_t kSamplesOfAll = 90'000, kSamplesOfOne = 6'000;

std::vector<double> list_of(const Eigen::VectorXd& values, double offset = 0.0, double scale = 1.0) {
  std::vector<double> out(static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = scale * (values(static_cast<Index>(k)) - offset);
  return out;
}

Json columns_json(const RecordingTrace& trace, std::size_t samples_max, std::size_t& samples) {
  const std::vector<double> time = list_of(trace.time_s, trace.time_s(0)), current = list_of(trace.current_a);
  const auto buckets = growing_buckets(time, current_steps(current), samples_max);
  const Eigen::VectorXd model = trace.voltage_v + trace.error_v;
  const HtmlSeries series[] = {bucket_times(buckets, time),
                               bucket_extremes(buckets, "measured_v", 1e-4, list_of(trace.voltage_v)),
                               bucket_extremes(buckets, "model_v", 1e-4, list_of(model)),
                               bucket_extremes(buckets, "error_mv", 0.02, list_of(trace.error_v, 0.0, 1e3)),
                               bucket_extremes(buckets, "current_a", 0.01, current)};
  Json out = Json::object();
  for (const HtmlSeries& one : series)
    out[one.name()] = {{"resolution", one.resolution()}, {"deltas", one.base64()}};
  samples = series[0].size();
  return out;
}

/// Seconds of error in equal bins out to where 99.8 % lie; the rest is in the outer bins.
Json histogram(const RecordingTrace& trace) {
  constexpr int kBins = 61;
  std::vector<double> sizes = list_of(trace.error_v.cwiseAbs());
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(0.998 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double reach = std::max(1e-4, *at), width = 2.0 * reach / kBins;
  std::vector<double> seconds(kBins, 0.0);
  for (Index row = 0; row < trace.error_v.size(); ++row) {
    const double bin = std::floor((trace.error_v(row) + reach) / width);
    seconds[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += trace.weight_s(row);
  }
  return {{"low_mv", -1e3 * reach}, {"width_mv", 1e3 * width}, {"seconds", seconds}};
}

/// Mean and rms of the error by SOC.
Json by_soc(const RecordingTrace& trace) {
  constexpr int kBins = 50;
  std::vector<std::array<double, 3>> sums(kBins + 1, {0.0, 0.0, 0.0});
  for (Index row = 0; row < trace.soc.size(); ++row) {
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

Json recordings(const CellIdentification& identified) {
  std::size_t files = 0;
  for (const OperatingPoint& point : identified.points) files += point.result.files.size();
  const std::size_t samples_max = std::min(kSamplesOfOne, kSamplesOfAll / files);
  Json out = Json::array();
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      const RecordingTrace& trace = file.trace;
      std::size_t samples = 0;
      Json columns = columns_json(trace, samples_max, samples);
      out.push_back({{"name", std::filesystem::path(file.path).filename().string()},
                     {"end_s", trace.time_s(trace.time_s.size() - 1) - trace.time_s(0)},
                     {"rms_mv", 1e3 * file.rms_v},
                     {"samples", samples},
                     {"columns", columns},
                     {"histogram", histogram(trace)},
                     {"by_soc", by_soc(trace)}});
    }
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
  const Json data = {{"recordings", recordings(reported.identified)},
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
