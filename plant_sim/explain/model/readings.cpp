// SPDX-License-Identifier: Apache-2.0
#include "explain/model/readings.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

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

/// The first row that is not before a time.
Index row_at(const VectorXd& time_s, double at_s) {
  const auto found = std::lower_bound(time_s.begin(), time_s.end(), at_s);
  return std::min<Index>(found - time_s.begin(), time_s.size() - 1);
}

}  // namespace

void Reader::keep_whole_bins(std::vector<Reading> all, const std::vector<double>& read,
                             const std::vector<int>& sensor, std::size_t sensors) {
  std::vector<Index> there;  // bins with a reading: a clock that jumps decides no memory
  for (const Reading& one : all) there.push_back(one.bin);
  std::sort(there.begin(), there.end());
  there.erase(std::unique(there.begin(), there.end()), there.end());
  std::vector<std::size_t> place(all.size());
  std::size_t near = 0;  // each sensor's readings rise
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (near + 1 < there.size() && there[near + 1] == all[k].bin) ++near;
    if (there[near] != all[k].bin)
      near = static_cast<std::size_t>(std::lower_bound(there.begin(), there.end(), all[k].bin) - there.begin());
    place[k] = near;
  }
  std::vector<double> count(there.size() * sensors, 0.0);
  for (std::size_t k = 0; k < all.size(); ++k)
    count[place[k] * sensors + static_cast<std::size_t>(sensor[k])] += all[k].share;
  std::vector<Index> kept(there.size(), -1);
  for (std::size_t b = 0; b < there.size(); ++b) {
    const auto* first = &count[b * sensors];
    if (std::count(first, first + sensors, 0.0) > 0) continue;
    kept[b] = static_cast<Index>(slot_.size());
    slot_.push_back(there[b]);
  }
  values_ = VectorXd::Zero(size());
  std::vector<double> weight(all.size(), 0.0);
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].bin = kept[place[k]];
    if (all[k].bin < 0) continue;
    weight[k] = all[k].share /
                (static_cast<double>(sensors) * count[place[k] * sensors + static_cast<std::size_t>(sensor[k])]);
    values_(all[k].bin) += weight[k] * read[k];
  }
  put_parts(all, weight);
}

/// Readings of many sensors lie between the same rows: what they are means of is said once for each row.
void Reader::put_parts(const std::vector<Reading>& readings, const std::vector<double>& weight) {
  Index rows = 0;
  for (const Reading& r : readings) rows = std::max(rows, r.row + 1);
  std::vector<Part> first(static_cast<std::size_t>(rows), {0, -1, 0.0}), second = first, more;
  const auto add = [&](Index row, Index bin, double by) {
    for (std::vector<Part>* parts : {&first, &second}) {
      Part& part = (*parts)[static_cast<std::size_t>(row)];
      if (part.bin >= 0 && part.bin != bin) continue;
      part = {row, bin, part.weight + by};
      return;
    }
    if (!more.empty() && more.back().row == row && more.back().bin == bin) {
      more.back().weight += by;
    } else {
      more.push_back({row, bin, by});
    }
  };
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& r = readings[k];
    if (r.bin < 0) continue;
    const double part = r.row == 0 ? 1.0 : r.part;
    add(r.row, r.bin, weight[k] * part);
    if (part < 1.0) add(r.row - 1, r.bin, weight[k] * (1.0 - part));
  }
  for (const std::vector<Part>* parts : {&first, &second, &more}) {
    std::copy_if(parts->begin(), parts->end(), std::back_inserter(parts_),
                 [](const Part& p) { return p.bin >= 0; });
  }
}

void Reader::keep(const std::vector<bool>& bins) {
  std::vector<Index> kept(bins.size(), -1), slot;
  std::vector<double> time_s, values;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (!bins[b]) continue;
    kept[b] = static_cast<Index>(slot.size());
    slot.push_back(slot_[b]);
    time_s.push_back(time_s_(static_cast<Index>(b)));
    values.push_back(values_(static_cast<Index>(b)));
  }
  std::erase_if(parts_, [&](const Part& p) { return kept[static_cast<std::size_t>(p.bin)] < 0; });
  for (Part& p : parts_) p.bin = kept[static_cast<std::size_t>(p.bin)];
  slot_ = std::move(slot);
  time_s_ = Eigen::Map<const VectorXd>(time_s.data(), static_cast<Index>(time_s.size()));
  values_ = Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

Reader::Reading Reader::place_of(const VectorXd& time_s, Index from, double at_s) {
  // A reading that is older than a row belongs further back.
  Index row = from;
  double begin = row > 0 ? time_s(row - 1) : time_s(row);
  while (row > 1 && at_s < begin) begin = time_s(--row - 1);
  const double width = time_s(row) - begin;
  return {row, 0, width > 0.0 ? std::clamp((at_s - begin) / width, 0.0, 1.0) : 1.0, 1.0};
}

Reader Reader::of_roles(const plant::Recording& log, const std::vector<std::string>& roles, double bin_s) {
  Reader out;
  out.bin_s_ = bin_s;
  std::vector<Reading> all;
  std::vector<double> read;
  std::vector<int> sensor;
  int sensors = 0;
  for (const std::string& role : roles) {
    const auto readings = readings_of(log, role);
    if (readings.empty()) continue;
    const auto passes = log.passed_s.find(role);
    std::size_t next = 0;
    for (const auto& [row, one] : readings) {
      const auto bin = static_cast<Index>((one.time_s - log.time_s(0)) / bin_s);
      const auto add = [&, value = one.value](Reading reading, double share) {
        all.push_back({reading.row, bin, reading.part, share});
        read.push_back(value);
        sensor.push_back(sensors);
      };
      if (passes == log.passed_s.end()) {
        add(place_of(log.time_s, row, one.time_s), 1.0);
        continue;
      }
      const std::vector<double>& at_s = passes->second;
      while (next < at_s.size() && at_s[next] <= one.time_s) ++next;
      const double share = (one.time_s - at_s[next - 1]) / (at_s[next] - at_s[next - 1]);
      add(place_of(log.time_s, row_at(log.time_s, at_s[next - 1]), at_s[next - 1]), 1.0 - share);
      add(place_of(log.time_s, row_at(log.time_s, at_s[next]), at_s[next]), share);
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
  out.bin_s_ = bin_s;
  std::vector<Reading> all;
  std::vector<double> read;
  for (Index row = 0; row < by_row.size(); ++row) {
    if (!std::isfinite(by_row(row))) continue;
    all.push_back({row, static_cast<Index>((log.time_s(row) - log.time_s(0)) / bin_s), 1.0, 1.0});
    read.push_back(by_row(row));
  }
  if (all.empty()) return out;
  const std::vector<int> sensor(all.size(), 0);
  out.keep_whole_bins(std::move(all), read, sensor, 1);
  out.time_s_ = out.of(log.time_s);
  return out;
}

VectorXd Reader::even_time_s() const {
  VectorXd out(size());
  for (Index k = 0; k < out.size(); ++k) out(k) = bin_s_ * static_cast<double>(slot_[static_cast<std::size_t>(k)]);
  return out;
}

VectorXd Reader::of(const VectorXd& by_row) const {
  VectorXd out = VectorXd::Zero(size());
  for (const Part& p : parts_) out(p.bin) += p.weight * by_row(p.row);
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

VectorXd filled(VectorXd by_row) {
  double last = 0.0;
  for (const double v : by_row) {
    if (!std::isfinite(v)) continue;
    last = v;
    break;
  }
  for (double& v : by_row) {
    if (!std::isfinite(v)) v = last;
    last = v;
  }
  return by_row;
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
