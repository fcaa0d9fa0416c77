// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_buckets.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

std::vector<RowBucket> buckets_of(const std::vector<double>& time_s, const std::vector<bool>& step, double share) {
  std::vector<RowBucket> out;
  double step_at = time_s.empty() ? 0.0 : time_s[0];
  for (std::size_t row = 0; row < time_s.size(); ++row) {
    if (step[row]) step_at = time_s[row];
    const bool grows = !out.empty() && !step[row] &&
                       time_s[row] - time_s[out.back().first] < share * (time_s[row] - step_at);
    if (grows)
      out.back().last = row + 1;
    else
      out.push_back({row, row + 1});
  }
  return out;
}

std::size_t points_of(const std::vector<RowBucket>& buckets) {
  std::size_t points = 0;
  for (const RowBucket& b : buckets) points += b.last - b.first > 1 ? 2U : 1U;
  return points;
}

}  // namespace

std::vector<RowBucket> growing_buckets(const std::vector<double>& time_s, const std::vector<bool>& step,
                                       std::size_t points_max, double share) {
  VOLTLAP_DEMAND(step.size() == time_s.size());
  VOLTLAP_DEMAND(share > 0.0 && points_max > 0);
  std::vector<RowBucket> out = buckets_of(time_s, step, share);
  while (points_of(out) > points_max && share < 1.0) out = buckets_of(time_s, step, share *= 1.5);
  // Too many steps for that, as in a drive: buckets of equal length.
  for (std::size_t rows = 2; points_of(out) > points_max; rows = rows + (rows + 1) / 2) {
    out.clear();
    for (std::size_t row = 0; row < time_s.size(); row += rows)
      out.push_back({row, std::min(row + rows, time_s.size())});
  }
  VOLTLAP_DEMAND(time_s.empty() || (out.front().first == 0 && out.back().last == time_s.size()));
  return out;
}

std::vector<bool> current_steps(const std::vector<double>& current_a) {
  constexpr double kShare = 0.05;
  double most = 0.0;
  for (const double i : current_a) most = std::max(most, std::abs(i));
  std::vector<bool> out(current_a.size(), false);
  for (std::size_t row = 1; row < current_a.size(); ++row)
    out[row] = std::abs(current_a[row] - current_a[row - 1]) > kShare * most;
  return out;
}

HtmlSeries bucket_times(const std::vector<RowBucket>& buckets, const std::vector<double>& time_s) {
  constexpr double kResolution = 0.01;  // s
  HtmlSeries out("time_s", kResolution);
  for (const RowBucket& b : buckets) {
    out.add(time_s[b.first]);
    if (b.last - b.first > 1) out.add(time_s[b.last - 1]);
  }
  return out;
}

HtmlSeries bucket_extremes(const std::vector<RowBucket>& buckets, const std::string& name, double resolution,
                           const std::vector<double>& values) {
  VOLTLAP_DEMAND(buckets.empty() || buckets.back().last <= values.size());
  HtmlSeries out(name, resolution);
  for (const RowBucket& b : buckets) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(b.first),
               end = values.begin() + static_cast<std::ptrdiff_t>(b.last);
    const auto [low, high] = std::minmax_element(begin, end);
    out.add(low < high ? *low : *high);
    if (b.last - b.first > 1) out.add(low < high ? *high : *low);
  }
  return out;
}

}  // namespace voltlap::plant
