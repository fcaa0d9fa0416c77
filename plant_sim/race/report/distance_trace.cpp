// SPDX-License-Identifier: Apache-2.0
#include "race/report/distance_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kDistance = 0, kTime = 1;

constexpr TraceChannel kChannels[] = {
    {"distance_m", "m", 3, [](const TimeSample& s) { return s.course_m; }},
    {"time_s", "s", 4, [](const TimeSample& s) { return s.time_s; }},
    {"speed_mps", "m/s", 3, [](const TimeSample& s) { return s.speed_mps; }},
    {"power_kw", "kW", 3, [](const TimeSample& s) { return 1e-3 * s.power_w; }},
    {"power_mean_500ms_kw", "kW", 3, [](const TimeSample& s) { return 1e-3 * s.power_mean_w; }},
    {"soc_pct", "%", 3, [](const TimeSample& s) { return 100.0 * s.soc; }},
    {"cell_voltage_min_v", "V", 4,
     [](const TimeSample& s) { return *std::min_element(s.cell_voltage_v->begin(), s.cell_voltage_v->end()); }},
    {"battery_temperature_c", "°C", 2, [](const TimeSample& s) { return s.battery_temperature_c; }},
    {"motor_temperature_c", "°C", 2, [](const TimeSample& s) { return s.motor_temperature_c; }},
    {"longitudinal_mps2", "m/s²", 2, [](const TimeSample& s) { return s.longitudinal_mps2; }},
    {"lateral_mps2", "m/s²", 2, [](const TimeSample& s) { return s.lateral_mps2; }},
};

}  // namespace

std::span<const TraceChannel> trace_channels() { return kChannels; }

DistanceTrace::DistanceTrace() : columns_(std::size(kChannels)) {}

void DistanceTrace::append(const std::vector<double>& point) {
  VOLTLAP_DEMAND(point.size() == columns_.size() && std::isfinite(point[kDistance]) && std::isfinite(point[kTime]));
  for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c].push_back(point[c]);
}

void DistanceTrace::add(const TimeSample& sample) {
  VOLTLAP_DEMAND(sample.cell_voltage_v != nullptr && !sample.cell_voltage_v->empty());
  std::vector<double> now;
  for (const TraceChannel& channel : kChannels) now.push_back(channel.value(sample));
  if (last_.empty()) {
    // The race begins before its first sample.
    last_ = now;
    last_[kDistance] = last_[kTime] = 0.0;
    append(last_);
  }
  VOLTLAP_DEMAND(now[kTime] >= last_[kTime]);
  std::vector<double> point(now.size());
  for (double next = columns_[kDistance].back() + step_m_; next <= now[kDistance]; next += step_m_) {
    const double part = (next - last_[kDistance]) / (now[kDistance] - last_[kDistance]);
    for (std::size_t c = 0; c < now.size(); ++c) point[c] = last_[c] + part * (now[c] - last_[c]);
    point[kDistance] = next;
    append(point);
  }
  last_ = std::move(now);
  if (columns_[kDistance].size() > kPointsMax) halve();
}

void DistanceTrace::halve() {
  for (std::vector<double>& column : columns_) {
    for (std::size_t i = 0; 2 * i < column.size(); ++i) column[i] = column[2 * i];
    column.resize((column.size() + 1) / 2);
  }
  step_m_ *= 2.0;
}

void DistanceTrace::close(double end_s, std::optional<double> end_m) {
  VOLTLAP_DEMAND(std::isfinite(end_s));
  if (last_.empty()) return;
  std::vector<double> point = last_;
  point[kDistance] = end_m.value_or(last_[kDistance]);
  point[kTime] = end_m ? end_s : last_[kTime];
  // The last tick drives past the line by some millimetres; the finish takes the place of what is there.
  constexpr double kSame_m = 1e-3;
  while (columns_[kDistance].size() > 1 && columns_[kDistance].back() > point[kDistance] - kSame_m) {
    for (std::vector<double>& column : columns_) column.pop_back();
  }
  if (point[kDistance] > columns_[kDistance].back()) append(point);
}

std::string trace_json(const DistanceTrace& trace) {
  std::string out = "{";
  auto to = std::back_inserter(out);
  for (std::size_t c = 0; c < std::size(kChannels); ++c) {
    fmt::format_to(to, "{}\n    \"{}\": [", c == 0 ? "" : ",", kChannels[c].name);
    const char* comma = "";
    for (const double value : trace.columns()[c]) {
      if (std::isfinite(value)) fmt::format_to(to, "{}{:.{}f}", comma, value, kChannels[c].digits);
      else fmt::format_to(to, "{}null", comma);
      comma = ",";
    }
    out += "]";
  }
  return out + "\n  }";
}

}  // namespace voltlap::plant
