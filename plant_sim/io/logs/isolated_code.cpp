// SPDX-License-Identifier: Apache-2.0
#include "io/logs/isolated_code.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMostSamples = 3, kLeastSteps = 20;
constexpr double kTimesUsual = 20.0;

/// Sizes of the steps between samples that are no code, those of zero left out.
std::vector<double> other_steps(std::span<const double> value, double code) {
  std::vector<double> out;
  for (std::size_t k = 1; k < value.size(); ++k) {
    if (value[k] == code || value[k - 1] == code || value[k] == value[k - 1]) continue;
    out.push_back(std::abs(value[k] - value[k - 1]));
  }
  return out;
}

}  // namespace

bool all_ones_is_no_value(std::span<const double> value, double code) {
  VOLTLAP_DEMAND(std::isfinite(code));
  if (std::find(value.begin(), value.end(), code) == value.end()) return false;
  const std::vector<double> steps = other_steps(value, code);
  if (steps.size() < kLeastSteps) return false;
  const double usual = kTimesUsual * median(steps), largest = *std::max_element(steps.begin(), steps.end());
  VOLTLAP_DEMAND(usual > 0.0 && largest > 0.0);
  for (std::size_t k = 0; k < value.size(); ++k) {
    if (value[k] != code) continue;
    std::size_t end = k;
    while (end < value.size() && value[end] == code) ++end;
    if (k == 0 || end == value.size() || end - k > kMostSamples) return false;
    const double before = value[k - 1], after = value[end];
    const double least_jump = std::min(std::abs(code - before), std::abs(code - after));
    if (least_jump <= std::max(usual, largest) || std::abs(after - before) > usual) return false;
    k = end;
  }
  return true;
}

}  // namespace voltlap::plant
