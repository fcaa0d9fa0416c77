// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/counted_charge.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kSecondsPerHour = 3600.0;
constexpr double kAgrees = 0.1;     // of the charge by the rows: a counter of another battery, or of one way alone
constexpr double kRestarts = 0.01;  // of the rows, at most

}  // namespace

VectorXd counted_current(const Recording& log) {
  const VectorXd *charge = log.find("charge_ah"), *current = log.find("current");
  if (charge == nullptr || current == nullptr || log.age_s.contains("charge_ah")) return {};
  VectorXd out = VectorXd::Constant(log.rows(), std::numeric_limits<double>::quiet_NaN());
  const double most = current->array().isFinite().select(current->array(), 0.0).abs().maxCoeff();
  double product = 0.0, square = 0.0, restarts = 0.0;
  for (Index row = 1; row < log.rows(); ++row) {
    const double mean =
        kSecondsPerHour * ((*charge)(row) - (*charge)(row - 1)) / (log.time_s(row) - log.time_s(row - 1));
    const double straight = 0.5 * ((*current)(row - 1) + (*current)(row));
    if (!std::isfinite(mean + straight)) continue;
    if (std::abs(mean) > (1.0 + kAgrees) * most) {
      restarts += 1.0;
      continue;
    }
    out(row) = mean;
    product += mean * straight;
    square += straight * straight;
  }
  const bool agrees = std::abs(std::abs(product) - square) < kAgrees * square;
  if (!agrees || restarts > kRestarts * static_cast<double>(log.rows())) return {};
  if (product < 0.0) out = -out;
  double beyond = 0.0, steps = 0.0;
  for (Index row = 1; row < log.rows(); ++row) {
    const double step = (*current)(row) - (*current)(row - 1);
    if (!std::isfinite(out(row) + step)) continue;
    beyond += std::pow(out(row) - (*current)(row) + 0.5 * step, 2);
    steps += step * step;
  }
  return beyond < steps ? out : VectorXd();
}

CurrentRange usual_range(const VectorXd& current_a) {
  constexpr double kSeldom = 0.05;  // of the rows
  std::vector<double> sorted;
  for (const double a : current_a)
    if (std::isfinite(a)) sorted.push_back(a);
  if (sorted.empty()) return {};
  const auto at = [&](double part) {
    const auto place = static_cast<std::ptrdiff_t>(part * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + place, sorted.end());
    return sorted[static_cast<std::size_t>(place)];
  };
  return {at(kSeldom), at(1.0 - kSeldom)};
}

}  // namespace voltlap::plant
