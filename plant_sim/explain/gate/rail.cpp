// SPDX-License-Identifier: Apache-2.0
#include "explain/gate/rail.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "explain/gate/integrity.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Rows = std::vector<bool>;

constexpr double kBeyondStep = 1.01;  // of readings that are a step apart, but for their digits

/// Standard deviation of readings at rest; 0 where there are few.
double noise_at_rest(const VectorXd& current, double largest) {
  constexpr double kRest = 0.05, kOfNormal = 1.4826;  // of the largest reading
  constexpr std::size_t kLeast = 50;
  std::vector<double> rest;
  for (const double i : current) {
    if (std::abs(i) < kRest * largest) rest.push_back(i);
  }
  if (rest.size() < kLeast) return 0.0;
  const auto half = rest.begin() + static_cast<std::ptrdiff_t>(rest.size() / 2);
  std::nth_element(rest.begin(), half, rest.end());
  const double middle = *half;
  for (double& i : rest) i = std::abs(i - middle);
  std::nth_element(rest.begin(), half, rest.end());
  return kOfNormal * *half;
}

/// Number of readings in the pile at the upper end of `values`, which fall by `step` or more; 0: there is none.
/// `noise`: of the sensor at rest.
std::size_t pile_of(const std::vector<double>& values, double step, double noise, Index rows) {
  constexpr double kNarrowest = 1e-4, kWidest = 0.03;  // of the largest reading: the noise of its sensor
  constexpr double kSigmas = 6.0;                      // or as wide as that is at rest
  constexpr double kSteps = 3.0;                       // as far as noise blurs coarse steps
  constexpr double kWider = 1.25;
  constexpr double kLeast = 20.0, kLeastShare = 0.005;  // readings; of all rows
  constexpr double kSteep = 3.0;                        // times as many as in the same width below
  if (values.empty()) return 0;
  const double most = values.front();
  const auto within = [&](double width) {
    const auto end =
        std::partition_point(values.begin(), values.end(), [&](double v) { return v >= most - width; });
    return static_cast<double>(end - values.begin());
  };
  // Within less than a step there is one value, and below it nothing: that is not steep.
  const double widest = std::max({kWidest * most, kSteps * kBeyondStep * step, kSigmas * noise});
  for (double width = std::max(kNarrowest * most, kBeyondStep * step);; width = std::min(widest, width * kWider)) {
    const double in = within(width), below = within(2.0 * width) - in;
    if (in >= kLeast && in >= kLeastShare * static_cast<double>(rows) && in >= kSteep * below) {
      return static_cast<std::size_t>(in);
    }
    if (width >= widest) return 0;
  }
}

/// Mean and spread of the readings around the middle of the pile; what passes through on its way stays out.
void settle(const std::vector<double>& pile, double step, Rail& out) {
  constexpr double kNear = 2.5, kOfNormal = 1.4826, kNearlyAll = 0.98;
  const double middle = pile[pile.size() / 2];
  std::vector<double> away;
  for (const double v : pile) away.push_back(std::abs(v - middle));
  const auto half = away.begin() + static_cast<std::ptrdiff_t>(away.size() / 2);
  std::nth_element(away.begin(), half, away.end());
  const auto alike = static_cast<double>(std::count(away.begin(), away.end(), 0.0));
  // Of coarse steps most readings can be one value though noise moves many to the next.
  const bool is_blurred = *half == 0.0 && alike < kNearlyAll * static_cast<double>(pile.size());
  const double reach = is_blurred ? kBeyondStep * step : kNear * kOfNormal * *half;
  double sum = 0.0, square = 0.0, count = 0.0;
  for (const double v : pile) {
    if (std::abs(v - middle) > reach) continue;
    sum += v - middle;
    square += (v - middle) * (v - middle);
    count += 1.0;
  }
  out.limit_a = middle + sum / count;
  out.noise_a = std::sqrt(square / count);
}

/// Readings of one sign, largest first.
std::vector<double> falling(const VectorXd& current, double sign) {
  std::vector<double> out;
  for (const double i : current) {
    if (sign * i > 0.0) out.push_back(sign * i);
  }
  std::sort(out.begin(), out.end(), std::greater<>());
  return out;
}

/// Do the other rows know what the model makes of a large current? A discharge at one current alone has no limit.
bool is_shown_elsewhere(const VectorXd& current, const Rows& others, double limit_a) {
  constexpr double kLarge = 0.3, kLeast = 100.0, kLeastShare = 0.02;  // of the limit; rows; of all rows
  double rows = 0.0;
  for (Index row = 0; row < current.size(); ++row) {
    if (others[static_cast<std::size_t>(row)] && std::abs(current(row)) > kLarge * limit_a) rows += 1.0;
  }
  return rows >= kLeast && rows >= kLeastShare * static_cast<double>(current.size());
}

}  // namespace

std::optional<Rail> rail_of(const VectorXd& current) {
  constexpr double kSigmas = 8.0, kOneValue = 1e-4, kAlike = 0.02;
  Rail out;
  out.step_a = step_of(current);
  constexpr double kLeast = 0.05;  // of the largest reading: a rest that reads a step below zero is a pile too
  double largest = 0.0;
  for (const double i : current) largest = std::abs(i) > largest ? std::abs(i) : largest;
  const double noise = noise_at_rest(current, largest);
  double most = 0.0, sign = 1.0;  // readings times limit
  for (const double s : {1.0, -1.0}) {
    std::vector<double> pile = falling(current, s);
    const std::size_t n = pile_of(pile, out.step_a, noise, current.size());
    const double weight = n == 0 || pile.front() < kLeast * largest ? 0.0 : static_cast<double>(n) * pile.front();
    if (weight <= most) continue;
    most = weight;
    sign = s;
    pile.resize(n);
    settle(pile, out.step_a, out);
  }
  if (most == 0.0) return std::nullopt;
  out.from_a = out.limit_a - kSigmas * std::max(out.noise_a, kOneValue * out.limit_a);
  const std::vector<double> others = falling(current, -sign);
  const bool symmetric = !others.empty() && std::abs(others.front() - out.limit_a) < kAlike * out.limit_a;
  Rows elsewhere;
  for (const double i : current) {
    out.at.push_back((symmetric ? std::abs(i) : sign * i) >= out.from_a);
    elsewhere.push_back(!out.at.back());
  }
  if (!is_shown_elsewhere(current, elsewhere, out.limit_a)) return std::nullopt;
  return out;
}

void mask_rail(const Rail& rail, const Recording& log, std::vector<Masked>& masked) {
  const std::string why =
      fmt::format("it reads its limit of {:.1f} A: what flowed is told by the voltage", rail.limit_a);
  for (std::size_t row = 0; row < rail.at.size(); ++row) {
    if (!rail.at[row]) continue;
    std::size_t last = row;
    while (last + 1 < rail.at.size() && rail.at[last + 1]) ++last;
    masked.push_back({"current", log.time_s(static_cast<Index>(row)), log.time_s(static_cast<Index>(last)), why});
    row = last;
  }
}

}  // namespace voltlap::plant
