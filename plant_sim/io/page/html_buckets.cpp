// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_buckets.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// Whether a line begins anew at a row.
bool begins_at(const std::vector<bool>& begins, std::size_t row) { return !begins.empty() && begins[row]; }

std::vector<RowBucket> buckets_of(const std::vector<double>& time_s, const std::vector<bool>& step,
                                  const std::vector<bool>& begins, double share, double longest_s) {
  std::vector<RowBucket> out;
  double step_at = time_s.empty() ? 0.0 : time_s[0];
  for (std::size_t row = 0; row < time_s.size(); ++row) {
    const bool anew = step[row] || begins_at(begins, row);
    if (anew) step_at = time_s[row];
    const double length_s = out.empty() ? 0.0 : time_s[row] - time_s[out.back().first];
    const bool grows = !out.empty() && !anew && length_s < std::min(longest_s, share * (time_s[row] - step_at));
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
                                       std::size_t points_max, const std::vector<bool>& begins) {
  constexpr double kShare = 0.02;
  VOLTLAP_DEMAND(step.size() == time_s.size() && points_max > 0);
  VOLTLAP_DEMAND(begins.empty() || begins.size() == time_s.size());
  // A bucket that is a visible stretch of the chart would draw its two extremes as a slope.
  const double span_s = time_s.empty() ? 0.0 : time_s.back() - time_s.front(),
               longest_s = 4.0 * span_s / static_cast<double>(points_max);
  double share = kShare;
  std::vector<RowBucket> out = buckets_of(time_s, step, begins, share, longest_s);
  while (points_of(out) > points_max && share < 1.0)
    out = buckets_of(time_s, step, begins, share *= 1.5, longest_s);
  // Too many steps for that, as in a drive: buckets of equal length. Where begins alone are too many, they stay.
  for (std::size_t rows = 2; points_of(out) > points_max && rows < 2 * time_s.size(); rows = rows + (rows + 1) / 2) {
    out.clear();
    for (std::size_t row = 0; row < time_s.size(); ++row) {
      if (out.empty() || begins_at(begins, row) || row - out.back().first >= rows)
        out.push_back({row, row + 1});
      else
        out.back().last = row + 1;
    }
  }
  VOLTLAP_DEMAND(time_s.empty() || (out.front().first == 0 && out.back().last == time_s.size()));
  return out;
}

std::vector<std::size_t> bucket_begins(const std::vector<RowBucket>& buckets, const std::vector<bool>& begins) {
  std::vector<std::size_t> out;
  std::size_t point = 0;
  for (const RowBucket& b : buckets) {
    if (b.first > 0 && begins_at(begins, b.first)) out.push_back(point);
    point += b.last - b.first > 1 ? 2U : 1U;
  }
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
