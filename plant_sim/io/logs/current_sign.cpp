// SPDX-License-Identifier: Apache-2.0
#include "io/logs/current_sign.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMostOfRow_s = 60.0;  // a row of a rest stands for no more
constexpr double kExplained = 0.02;    // of the squares: less is chance
constexpr double kNoise = 0.02;        // of the largest current: what moves by less is not switched but noisy

/// What of the current the voltage follows: at once, and behind these times, as the branches of a cell do and a voltage
/// that comes late.
constexpr std::array kBehind_s{0.0, 2.0, 30.0};
using Followed = std::array<double, kBehind_s.size()>;
static_assert(kBehind_s.size() == 3, "Sums::add names them");

struct Point {
  double q, v, weight;
  Followed i;
};

/// Places on the range of charge between which the voltage of an unloaded cell is a line: close at its steep ends.
constexpr std::array kKnots{0.0, 0.04, 0.15, 0.35, 0.65, 0.85, 0.96, 1.0};
constexpr Eigen::Index kCurrent = kKnots.size(), kVoltage = kCurrent + kBehind_s.size(), kColumns = kVoltage + 1;
using Products = Eigen::Matrix<double, kColumns, kColumns>;

/// Weighted squares and products about the mean of each part, of hats on the knots, currents and voltage.
struct Sums {
  Products of = Products::Zero();
  double weight = 0.0, most_i = 0.0;

  void add(const std::vector<Point>& part, double q_low, double q_high) {
    Eigen::Matrix<double, kColumns, 1> sum = Eigen::Matrix<double, kColumns, 1>::Zero();
    double own = 0.0;
    for (const Point& at : part) {
      const double place = q_high > q_low ? std::clamp((at.q - q_low) / (q_high - q_low), 0.0, 1.0) : 0.0;
      const auto above = std::upper_bound(kKnots.begin() + 1, kKnots.end() - 1, place) - kKnots.begin();
      const double low = kKnots[static_cast<std::size_t>(above - 1)], high = kKnots[static_cast<std::size_t>(above)];
      const double share = (place - low) / (high - low);
      const std::array<Eigen::Index, 6> column{above - 1, above, kCurrent, kCurrent + 1, kCurrent + 2, kVoltage};
      const std::array value{1.0 - share, share, at.i[0], at.i[1], at.i[2], at.v};
      for (std::size_t a = 0; a < column.size(); ++a) {
        sum(column[a]) += at.weight * value[a];
        for (std::size_t b = 0; b < column.size(); ++b) of(column[a], column[b]) += at.weight * value[a] * value[b];
      }
      own += at.weight;
      most_i = std::max(most_i, std::abs(at.i[0]));
    }
    if (own <= 0.0) return;
    of -= sum * sum.transpose() / own;
    weight += own;
  }
};

Sums sums_of(const CellLog& log) {
  std::vector<std::vector<Point>> parts(1);
  std::optional<double> first_v;  // levels apart from it are exact where the voltage stands still
  double q = 0.0, since_voltage_s = 0.0, low = 0.0, high = 0.0;
  Followed i{};
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (log.gap[row] || row == 0) {
      if (row > 0) parts.emplace_back();
      since_voltage_s = 0.0;
      i.fill(log.current_a[row]);
    }
    const double dt = row > 0 && !log.gap[row] ? log.time_s[row] - log.time_s[row - 1] : 0.0;
    if (dt > 0.0) {
      q += 0.5 * (log.current_a[row] + log.current_a[row - 1]) * dt;
      for (std::size_t k = 1; k < i.size(); ++k)
        i[k] += (log.current_a[row - 1] - i[k]) * -std::expm1(-dt / kBehind_s[k]);
    }
    i[0] = log.current_a[row];
    low = std::min(low, q);
    high = std::max(high, q);
    since_voltage_s += dt;
    if (!std::isfinite(log.voltage_v[row])) continue;
    if (!first_v) first_v = log.voltage_v[row];
    parts.back().push_back({q, log.voltage_v[row] - *first_v, std::min(since_voltage_s, kMostOfRow_s), i});
    since_voltage_s = 0.0;
  }
  Sums out;
  for (const std::vector<Point>& part : parts) out.add(part, low, high);
  return out;
}

/// Squares of the voltage that charge and current explain where the voltage rises with both (`way` 1) or falls with
/// both (-1), and nowhere the other way: min |v - way A x|^2 with x >= 0, one coordinate after the other.
double explained(const Sums& sums, double way) {
  constexpr int kSweeps = 300;
  constexpr Eigen::Index kRamps = kCurrent - 1, n = kVoltage - 1;
  // A ramp from one knot to the next is the sum of all hats from there on; the currents are as they are.
  Eigen::Matrix<double, n, kColumns> columns = Eigen::Matrix<double, n, kColumns>::Zero();
  for (Eigen::Index k = 0; k < kRamps; ++k) columns.row(k).segment(k + 1, kRamps - k).setOnes();
  for (Eigen::Index k = kRamps; k < n; ++k) columns(k, k + 1) = 1.0;
  const bool moves =
      sums.of(kCurrent, kCurrent) >= kNoise * kNoise * sums.most_i * sums.most_i * sums.weight && sums.most_i > 0.0;
  const Eigen::MatrixXd a = columns * sums.of * columns.transpose();
  const Eigen::VectorXd b = way * (columns * sums.of.col(kVoltage));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Eigen::Index k = 0; k < (moves ? n : kRamps); ++k) {
      if (a(k, k) > 0.0) x(k) = std::max(0.0, x(k) + (b(k) - a.row(k).dot(x)) / a(k, k));
    }
  }
  return 2.0 * b.dot(x) - x.dot(a * x);
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
  const Sums sums = sums_of(log);
  const double all = sums.of(kVoltage, kVoltage), rises = explained(sums, 1.0), falls = explained(sums, -1.0);
  if (std::max(rises, falls) <= kExplained * all) return 0.0;
  const double left = 2.0 * all - rises - falls;
  return (rises - falls) / std::min(rises + falls, std::max(left, kExplained * all));
}

}  // namespace voltlap::plant
