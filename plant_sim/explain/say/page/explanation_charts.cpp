// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/explanation_charts.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "explain/say/numbers.hpp"
#include "explain/say/page/shown_channel.hpp"
#include "io/page/html_buckets.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

constexpr std::size_t kPointsMax = 3000;  // twice what a screen has columns
constexpr std::size_t kCharts = 10;
constexpr std::size_t kStretches = 300;  // that were not used, drawn in a chart
constexpr int kBins = 24;
constexpr int kLeastInBin = 20;

/// The last value is held where there is none: such stretches are marked in the chart.
std::vector<double> filled(const VectorXd& values, double scale) {
  std::vector<double> out;
  double last = 0.0;
  for (const double v : values) {
    if (std::isfinite(v)) last = v * scale;
    out.push_back(last);
  }
  return out;
}

Json packed(const HtmlSeries& series) {
  return {{"resolution", series.resolution()}, {"deltas", series.base64()}};
}

double rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) return 0.0;
  const double step = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return std::round(value / step) * step;
}

/// Mean and middle half of the values in equal bins of `over`, between its outer hundredths.
Json binned(const VectorXd& over, const VectorXd& values, double scale) {
  std::vector<double> sorted;
  for (Index row = 0; row < over.size(); ++row) {
    if (std::isfinite(over(row)) && std::isfinite(values(row))) sorted.push_back(over(row));
  }
  if (sorted.size() < 100) return Json::array();
  std::sort(sorted.begin(), sorted.end());
  const double low = sorted[sorted.size() / 200], high = sorted[sorted.size() - 1 - sorted.size() / 200];
  if (!(high > low)) return Json::array();
  std::vector<std::vector<double>> bins(kBins);
  for (Index row = 0; row < over.size(); ++row) {
    const double at = std::floor((over(row) - low) / (high - low) * kBins);
    if (!std::isfinite(values(row)) || !(at >= 0.0 && at < kBins)) continue;
    bins[static_cast<std::size_t>(at)].push_back(values(row));
  }
  Json out = Json::array();
  for (int k = 0; k < kBins; ++k) {
    std::vector<double>& bin = bins[static_cast<std::size_t>(k)];
    if (bin.size() < kLeastInBin) continue;
    std::sort(bin.begin(), bin.end());
    double sum = 0.0;
    for (const double v : bin) sum += v;
    const double mean = sum / static_cast<double>(bin.size());
    out.push_back({rounded(low + (k + 0.5) * (high - low) / kBins), rounded(scale * mean),
                   rounded(scale * bin[bin.size() / 4]), rounded(scale * bin[3 * bin.size() / 4])});
  }
  return out;
}

Json against(const Explanation& e, const Trace& trace, double scale) {
  const Circumstances& c = e.circumstances;
  const std::pair<const char*, const VectorXd*> over[] = {{"current, A", &c.current_a},
                                                          {"SOC", &c.soc},
                                                          {"temperature, °C", &c.temperature_c},
                                                          {"speed, m/s", &c.speed_mps}};
  Json out = Json::array();
  for (const auto& [name, values] : over) {
    if (values->size() == 0) continue;
    const Json before = binned(*values, trace.before, scale);
    if (before.size() < 4) continue;
    out.push_back({{"name", name}, {"before", before}, {"after", binned(*values, trace.after, scale)}});
  }
  return out;
}

/// Stretches of a channel, or of what it is made of, that were not used.
Json unused(const Explanation& e, const Trace& trace) {
  const double begin = e.circumstances.time_s(0);
  Json out = Json::array();
  for (const Masked& m : e.masked) {
    const bool part = (trace.channel.ends_with("voltage") && m.channel.starts_with("cell_voltage_")) ||
                      (trace.channel == "temperature" && m.channel.starts_with("temperature_"));
    if (!part && m.channel != trace.channel && m.channel != "current" && m.channel != "time") continue;
    if (out.size() < kStretches) out.push_back({m.start_s - begin, m.end_s - begin});
  }
  return out;
}

/// What the answer changes most comes first.
std::vector<const Trace*> charted(const Explanation& e) {
  std::vector<const Trace*> out;
  for (const Trace& trace : e.traces) {
    if (!trace.member || is_changed(trace)) out.push_back(&trace);
  }
  const auto drop = [](const Trace* t) {
    const double before = rms_of(t->before);
    return before > 0.0 ? 1.0 - rms_of(t->after) / before : 0.0;
  };
  std::stable_sort(out.begin(), out.end(),
                   [&](const Trace* a, const Trace* b) { return drop(a) > drop(b) + 0.02; });
  if (out.size() > kCharts) out.resize(kCharts);
  return out;
}

/// Where the axis ends when a few rows are far beyond all others; null when none are.
Json axis_ends(const Trace& trace, double scale) {
  constexpr double kFew = 0.003, kBeyond = 4.0;
  std::vector<double> sizes;
  for (const VectorXd* values : {&trace.before, &trace.after}) {
    for (const double v : *values) {
      if (std::isfinite(v)) sizes.push_back(std::abs(v));
    }
  }
  if (sizes.empty()) return nullptr;
  std::sort(sizes.begin(), sizes.end());
  const double most = sizes[static_cast<std::size_t>((1.0 - kFew) * static_cast<double>(sizes.size() - 1))];
  if (most <= 0.0 || sizes.back() < kBeyond * most) return nullptr;
  const double step = std::pow(10.0, std::floor(std::log10(1.5 * scale * most)));
  return {{"most", step * std::ceil(1.5 * scale * most / step)}, {"largest", rounded(scale * sizes.back())}};
}

Json channel_json(const Explanation& e, const Trace& trace, const std::vector<RowBucket>& buckets) {
  const double before = rms_of(trace.before);
  const ShownUnit shown = shown_unit(trace.unit, before);
  const double fine = std::max(1e-9, 0.02 * shown.scale * (trace.floor > 0.0 ? trace.floor : before));
  const double resolution = std::pow(10.0, std::floor(std::log10(fine)));
  const auto pack = [&](const VectorXd& values) {
    return packed(bucket_extremes(buckets, trace.channel, resolution, filled(values, shown.scale)));
  };
  return {{"title", channel_title(e, trace)},
          {"unit", shown.unit},
          {"digits", std::clamp(static_cast<int>(-std::log10(resolution) - 0.5), 0, 4)},
          {"floor", rounded(shown.scale * trace.floor)},
          {"changed", is_changed(trace)},
          {"ends", axis_ends(trace, shown.scale)},
          {"before", pack(trace.before)},
          {"after", pack(trace.after)},
          {"unused", unused(e, trace)},
          {"against", against(e, trace, shown.scale)}};
}

}  // namespace

std::string explanation_charts(const Explanation& e) {
  Json out = {{"channels", Json::array()}};
  const Circumstances& c = e.circumstances;
  if (c.time_s.size() > 1 && !e.traces.empty()) {
    std::vector<double> time;
    for (const double t : c.time_s) time.push_back(t - c.time_s(0));
    const std::vector<double> current = filled(c.current_a, 1.0);
    const auto buckets = growing_buckets(time, current_steps(current), kPointsMax);
    const HtmlSeries times = bucket_times(buckets, time);
    out["samples"] = times.size();
    out["end_s"] = time.back();
    out["time_s"] = packed(times);
    out["current_a"] = packed(bucket_extremes(buckets, "current_a", 0.1, current));
    out["soc"] = packed(bucket_extremes(buckets, "soc", 1e-3, filled(c.soc, 1.0)));
    for (const Trace* trace : charted(e)) out["channels"].push_back(channel_json(e, *trace, buckets));
  }
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace voltlap::plant
