// SPDX-License-Identifier: Apache-2.0
#include "explain/model/readings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace voltlap::explain {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

struct Read {
  double time_s, value;
};

/// The readings that the rows hold, each once: at the row where it appears first.
std::vector<std::pair<Index, Read>> readings_of(const plant::Recording& log, const std::string& role) {
  const VectorXd& values = log.signals.at(role);
  const auto times = log.read_s.find(role);
  std::vector<std::pair<Index, Read>> out;
  double last = -std::numeric_limits<double>::infinity();
  for (Index row = 0; row < values.size(); ++row) {
    const double t = times == log.read_s.end() ? log.time_s(row) : times->second(row);
    if (!(t > last)) continue;
    last = t;
    if (std::isfinite(values(row)) && t >= log.time_s(0)) out.push_back({row, {t, values(row)}});
  }
  return out;
}

}  // namespace

void Reader::keep_whole_bins(std::vector<Reading> all, const std::vector<double>& read,
                             const std::vector<int>& sensor, std::size_t sensors) {
  Index bins = 0;
  for (const Reading& one : all) bins = std::max(bins, one.bin + 1);
  std::vector<std::vector<int>> count(static_cast<std::size_t>(bins), std::vector<int>(sensors, 0));
  for (std::size_t k = 0; k < all.size(); ++k)
    ++count[static_cast<std::size_t>(all[k].bin)][static_cast<std::size_t>(sensor[k])];
  std::vector<Index> place(static_cast<std::size_t>(bins), -1);
  for (std::size_t b = 0; b < place.size(); ++b) {
    if (std::count(count[b].begin(), count[b].end(), 0) > 0) continue;
    place[b] = static_cast<Index>(slot_.size());
    slot_.push_back(static_cast<Index>(b));
  }
  values_ = VectorXd::Zero(static_cast<Index>(slot_.size()));
  for (std::size_t k = 0; k < all.size(); ++k) {
    Reading one = all[k];
    const auto b = static_cast<std::size_t>(one.bin);
    if (place[b] < 0) continue;
    one.weight = 1.0 / (static_cast<double>(sensors) * count[b][static_cast<std::size_t>(sensor[k])]);
    one.bin = place[b];
    values_(one.bin) += one.weight * read[k];
    readings_.push_back(one);
  }
}

Reader Reader::of_roles(const plant::Recording& log, const std::vector<std::string>& roles, double bin_s) {
  Reader out;
  std::vector<Reading> all;
  std::vector<double> read;
  std::vector<int> sensor;
  int sensors = 0;
  for (const std::string& role : roles) {
    const auto readings = readings_of(log, role);
    if (readings.empty()) continue;
    for (const auto& [row, one] : readings) {
      const double before = row > 0 ? log.time_s(row - 1) : log.time_s(row);
      const double step = log.time_s(row) - before;
      // A reading that is older than a row belongs further back.
      Index at = row;
      double begin = before;
      while (at > 1 && one.time_s < begin) begin = log.time_s(--at - 1);
      const double width = at == row ? step : log.time_s(at) - begin;
      const double part = width > 0.0 ? std::clamp((one.time_s - begin) / width, 0.0, 1.0) : 1.0;
      all.push_back({at, static_cast<Index>((one.time_s - log.time_s(0)) / bin_s), part, 0.0});
      read.push_back(one.value);
      sensor.push_back(sensors);
    }
    ++sensors;
  }
  if (sensors == 0) return out;
  out.keep_whole_bins(std::move(all), read, sensor, static_cast<std::size_t>(sensors));
  out.time_s_ = out.of(log.time_s);
  return out;
}

Reader Reader::of_rows(const plant::Recording& log, const VectorXd& by_row, double bin_s) {
  Reader out;
  std::vector<Reading> all;
  std::vector<double> read;
  for (Index row = 0; row < by_row.size(); ++row) {
    if (!std::isfinite(by_row(row))) continue;
    all.push_back({row, static_cast<Index>((log.time_s(row) - log.time_s(0)) / bin_s), 1.0, 0.0});
    read.push_back(by_row(row));
  }
  if (all.empty()) return out;
  const std::vector<int> sensor(all.size(), 0);
  out.keep_whole_bins(std::move(all), read, sensor, 1);
  out.time_s_ = out.of(log.time_s);
  return out;
}

VectorXd Reader::of(const VectorXd& by_row) const {
  VectorXd out = VectorXd::Zero(static_cast<Index>(slot_.size()));
  for (const Reading& r : readings_) {
    const double now = by_row(r.row);
    out(r.bin) +=
        r.weight * (r.part >= 1.0 || r.row == 0 ? now : by_row(r.row - 1) + r.part * (now - by_row(r.row - 1)));
  }
  return out;
}

VectorXd Reader::matched(const Reader& other, const VectorXd& by_bin_of_other) const {
  VectorXd out = VectorXd::Constant(size(), kNothing);
  std::size_t at = 0;
  for (std::size_t k = 0; k < slot_.size(); ++k) {
    while (at < other.slot_.size() && other.slot_[at] < slot_[k]) ++at;
    if (at < other.slot_.size() && other.slot_[at] == slot_[k])
      out(static_cast<Index>(k)) = by_bin_of_other(static_cast<Index>(at));
  }
  return out;
}

double usual_interval_s(const plant::Recording& log, const std::string& role) {
  std::vector<double> steps;
  double last = kNothing;
  for (const auto& [row, one] : readings_of(log, role)) {
    if (std::isfinite(last)) steps.push_back(one.time_s - last);
    last = one.time_s;
  }
  if (steps.empty()) return 0.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace voltlap::explain
