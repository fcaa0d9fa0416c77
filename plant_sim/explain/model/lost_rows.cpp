// SPDX-License-Identifier: Apache-2.0
#include "explain/model/lost_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Rows before which one is missing amid a load that changes.
std::vector<Index> lost_before(const VectorXd& time_s, const VectorXd& current_a) {
  constexpr double kLong = 1.5, kMuch = 0.05, kMost = 0.1;  // usual intervals; of its RMS; of the rows
  constexpr Index kBeside = 3;                              // rows
  const double longest = kLong * row_interval_s(time_s);
  const double much = kMuch * std::sqrt(current_a.squaredNorm() / static_cast<double>(current_a.size()));
  std::vector<Index> out;
  for (Index row = 1; row < time_s.size(); ++row) {
    if (!(time_s(row) - time_s(row - 1) > longest)) continue;
    const Index first = std::max<Index>(0, row - kBeside), last = std::min(time_s.size(), row + kBeside);
    const auto beside = current_a.segment(first, last - first);
    if (beside.maxCoeff() - beside.minCoeff() > much) out.push_back(row);
  }
  if (static_cast<double>(out.size()) > kMost * static_cast<double>(time_s.size())) out.clear();
  return out;
}

}  // namespace

double row_interval_s(const VectorXd& time_s) {
  std::vector<double> steps;
  for (Index row = 1; row < time_s.size(); ++row) steps.push_back(time_s(row) - time_s(row - 1));
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

void leave_out_lost_rows(plant::Recording& log, const VectorXd& current_a) {
  const std::vector<Index> lost = lost_before(log.time_s, current_a);
  for (const auto& [role, read_s] : log.read_s) {
    if (role.find("voltage") == std::string::npos) continue;
    VectorXd& values = log.signals.at(role);
    for (const Index after : lost) {
      Index row = after;  // a reading may come some rows later
      while (row < values.size() && !(read_s(row) > log.time_s(after - 1))) ++row;
      for (; row < values.size() && read_s(row) < log.time_s(after); ++row)
        values(row) = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

}  // namespace voltlap::explain
