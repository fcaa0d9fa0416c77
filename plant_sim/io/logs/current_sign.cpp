// SPDX-License-Identifier: Apache-2.0
#include "io/logs/current_sign.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMostOfRow_s = 60.0;  // a row of a rest stands for no more
constexpr double kExplained = 0.02;    // of the squares: less is chance
constexpr double kNoise = 0.02;        // of the largest current: what moves by less is not switched but noisy

struct Point {
  double q, i, v, weight;
};

/// Weighted squares and products about the mean of their part.
struct Sums {
  double qq = 0.0, qi = 0.0, ii = 0.0, qv = 0.0, iv = 0.0, vv = 0.0;
  double weight = 0.0, most_i = 0.0;

  void add(const std::vector<Point>& part) {
    Point mean{};
    for (const Point& at : part) {
      mean.weight += at.weight;
      mean.q += at.weight * at.q;
      mean.i += at.weight * at.i;
      mean.v += at.weight * at.v;
    }
    if (mean.weight <= 0.0) return;
    weight += mean.weight;
    for (const Point& at : part) {
      const double q = at.q - mean.q / mean.weight, i = at.i - mean.i / mean.weight, v = at.v - mean.v / mean.weight;
      qq += at.weight * q * q;
      qi += at.weight * q * i;
      ii += at.weight * i * i;
      qv += at.weight * q * v;
      iv += at.weight * i * v;
      vv += at.weight * v * v;
      most_i = std::max(most_i, std::abs(at.i));
    }
  }
};

Sums sums_of(const CellLog& log) {
  Sums sums;
  std::vector<Point> part;
  double q = 0.0, since_voltage_s = 0.0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (log.gap[row]) {
      sums.add(part);
      part.clear();
      since_voltage_s = 0.0;
    }
    const double dt = row > 0 && !log.gap[row] ? log.time_s[row] - log.time_s[row - 1] : 0.0;
    if (dt > 0.0) q += 0.5 * (log.current_a[row] + log.current_a[row - 1]) * dt;
    since_voltage_s += dt;
    if (!std::isfinite(log.voltage_v[row])) continue;
    part.push_back({q, log.current_a[row], log.voltage_v[row], std::min(since_voltage_s, kMostOfRow_s)});
    since_voltage_s = 0.0;
  }
  sums.add(part);
  return sums;
}

/// More than this between two samples is a gap.
double gap_after_s(const Channel& channel) {
  constexpr double kLeast_s = 60.0, kTimes = 50.0;
  return std::max(kLeast_s, kTimes * median(differences(channel.time_s)));
}

/// A row for each sample of either.
CellLog rows_of(const Channel& current, const Channel& voltage) {
  VOLTLAP_DEMAND(current.time_s.size() == current.value.size() && voltage.time_s.size() == voltage.value.size());
  CellLog out;
  const double current_gap_s = gap_after_s(current), voltage_gap_s = gap_after_s(voltage);
  double held = std::nan(""), current_s = 0.0, voltage_s = 0.0;
  bool gap = false;
  std::size_t i = 0, v = 0;
  while (i < current.size() || v < voltage.size()) {
    const bool is_current = v >= voltage.size() || (i < current.size() && current.time_s[i] <= voltage.time_s[v]);
    const Channel& from = is_current ? current : voltage;
    std::size_t& at = is_current ? i : v;
    const double t = from.time_s[at], value = from.value[at];
    ++at;
    if (!std::isfinite(value)) continue;
    double& last_s = is_current ? current_s : voltage_s;
    gap = gap || (!out.time_s.empty() && t - last_s > (is_current ? current_gap_s : voltage_gap_s));
    last_s = t;
    if (is_current) held = value;
    if (!std::isfinite(held)) continue;
    out.time_s.push_back(t);
    out.current_a.push_back(held);
    out.voltage_v.push_back(is_current ? std::nan("") : value);
    out.gap.push_back(gap && out.time_s.size() > 1);
    gap = false;
  }
  return out;
}

}  // namespace

double whole_sign_evidence(const Channel& current, const Channel& voltage) {
  return whole_sign_evidence(rows_of(current, voltage));
}

double whole_sign_evidence(const CellLog& log) {
  VOLTLAP_DEMAND(log.voltage_v.size() == log.rows() && log.gap.size() == log.rows());
  constexpr double kAlike = 1e-6;  // charge and current that cannot be told apart
  Sums s = sums_of(log);
  if (s.vv <= 0.0) return 0.0;
  if (s.ii < kNoise * kNoise * s.most_i * s.most_i * s.weight) s.ii = s.qi = s.iv = 0.0;
  double by_q = s.qq > 0.0 ? s.qv * std::abs(s.qv) / s.qq : 0.0, by_i = s.ii > 0.0 ? s.iv * std::abs(s.iv) / s.ii : 0.0;
  const double det = s.qq * s.ii - s.qi * s.qi;
  if (det > kAlike * s.qq * s.ii && det > 0.0) {
    const double b = (s.ii * s.qv - s.qi * s.iv) / det, c = (s.qq * s.iv - s.qi * s.qv) / det;
    by_q = b * std::abs(b) * det / s.ii;  // what the squares would lose without it
    by_i = c * std::abs(c) * det / s.qq;
  }
  const double both = std::abs(by_q) + std::abs(by_i);
  return both > kExplained * s.vv ? (by_q + by_i) / both : 0.0;
}

}  // namespace voltlap::plant
