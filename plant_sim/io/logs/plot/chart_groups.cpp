// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/chart_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "io/logs/plot/signal_unit.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMostInChart = 6;  // colours that are told apart
constexpr double kOfOneSize = 6.0;       // largest of a chart over its smallest

double size_of(const SignalCourse& course) { return std::max(std::abs(course.low()), std::abs(course.high())); }

/// The quantity; where one has several charts, with the values of each.
std::string title_of(const ChartGroup& group, bool alone_of_unit, const std::vector<SignalCourse>& courses) {
  if (alone_of_unit) return group.quantity;
  double low = courses[group.signals.front()].low(), high = courses[group.signals.front()].high();
  for (const std::size_t k : group.signals) {
    low = std::min(low, courses[k].low());
    high = std::max(high, courses[k].high());
  }
  const std::string values = low == high ? fmt::format("{:.4g}", low) : fmt::format("{:.4g} to {:.4g}", low, high);
  return fmt::format("{}, {}{}", group.quantity, values, group.unit.empty() ? "" : " " + group.unit);
}

}  // namespace

std::vector<ChartGroup> chart_groups(const std::vector<std::size_t>& chosen, const std::vector<SignalHead>& heads,
                                     const std::vector<SignalCourse>& courses) {
  VOLTLAP_DEMAND(courses.size() == heads.size());
  std::map<std::pair<std::size_t, std::string>, std::vector<std::size_t>> by_unit;
  for (const std::size_t k : chosen) {
    const SignalUnit unit = signal_unit(heads[k].unit);
    by_unit[{unit.rank, unit.text}].push_back(k);
  }
  std::vector<ChartGroup> out;
  for (auto& [rank_and_unit, signals] : by_unit) {
    std::stable_sort(signals.begin(), signals.end(),
                     [&](std::size_t a, std::size_t b) { return size_of(courses[a]) > size_of(courses[b]); });
    const std::string& unit = rank_and_unit.second;
    const std::string known = signal_unit(heads[signals.front()].unit).quantity;
    const std::string quantity = known.empty() ? "In " + unit : known;
    const std::size_t first = out.size();
    double largest = 0.0;
    for (const std::size_t k : signals) {
      const double size = size_of(courses[k]);
      if (out.size() == first || out.back().signals.size() == kMostInChart || size * kOfOneSize < largest) {
        out.push_back({quantity, {}, unit, {}, 0});
        largest = size;
      }
      out.back().signals.push_back(k);
      out.back().decimals = std::max(out.back().decimals, courses[k].decimals());
    }
    for (std::size_t g = first; g < out.size(); ++g)
      out[g].title = title_of(out[g], out.size() == first + 1, courses);
  }
  for (ChartGroup& group : out) std::sort(group.signals.begin(), group.signals.end());
  return out;
}

}  // namespace voltlap::plant
