// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/operating_grid.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSameTemperature = 4.0, kSameCurrent = 0.2;  // K; relative

/// The one discharge current of a test, or 0 when it draws several.
double single_current(const CellLog& log) {
  std::vector<double> drawn;
  double most = 0.0;
  for (const double i : log.current_a) most = std::max(most, i);
  for (const double i : log.current_a) {
    if (i > 0.05 * most) drawn.push_back(i);
  }
  if (drawn.size() < 10) return 0.0;
  // A resistor's current falls with the voltage, most in the last pulse: a third between a tenth and nine tenths of the
  // rows is still one test.
  const double low = quantile(drawn, 0.1), high = quantile(drawn, 0.9), middle = median(drawn);
  if (high - low >= 0.35 * middle) return 0.0;
  // Pulses of a few seconds are few rows: they are a current of their own all the same.
  constexpr double kOther = 1.5, kLeastSeconds = 3.0;
  double other_s = 0.0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    if (std::abs(log.current_a[row]) > kOther * middle && !log.gap[row])
      other_s += log.time_s[row] - log.time_s[row - 1];
  }
  return other_s < kLeastSeconds ? middle : 0.0;
}

/// A recording without a fast current tells the OCV and the capacity, but no resistance: it makes no point of its own.
bool is_slow(const CellLog& log) {
  constexpr double kSlow = 1.0 / 8.0;  // C-rate
  const std::vector<double> drawn = charge_drawn_ah(log, CurrentHold::kLinear);
  const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
  return largest_current(log) < kSlow * (*high - *low);
}

/// Those of the values whose recordings are fast; all of them when none is.
std::vector<double> of_fast(const std::vector<double>& values, const std::vector<bool>& slow) {
  std::vector<double> out;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!slow[k]) out.push_back(values[k]);
  }
  return out.empty() ? values : out;
}

template <class Same>
std::vector<double> clusters(std::vector<double> values, const Same& same) {
  VOLTLAP_DEMAND(!values.empty());
  std::sort(values.begin(), values.end());
  std::vector<double> centres, members;
  for (const double value : values) {
    if (!members.empty() && !same(members.front(), value)) {
      centres.push_back(median(members));
      members.clear();
    }
    members.push_back(value);
  }
  centres.push_back(median(members));
  return centres;
}

std::size_t nearest(const std::vector<double>& centres, double value) {
  const auto by_distance = [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); };
  return static_cast<std::size_t>(std::min_element(centres.begin(), centres.end(), by_distance) - centres.begin());
}

}  // namespace

OperatingGrid operating_grid(const std::vector<CellLog>& logs, const std::vector<double>& temperatures_c) {
  VOLTLAP_DEMAND(!logs.empty() && temperatures_c.size() == logs.size());
  std::vector<double> currents;
  std::vector<bool> slow;
  for (const CellLog& log : logs) {
    currents.push_back(single_current(log));
    slow.push_back(is_slow(log));
  }
  const std::vector<double> told = of_fast(currents, slow);
  const bool by_current = std::all_of(told.begin(), told.end(), [](double i) { return i > 0.0; });
  if (!by_current) std::fill(currents.begin(), currents.end(), 0.0);
  OperatingGrid grid;
  grid.temperatures_c =
      clusters(of_fast(temperatures_c, slow), [](double a, double b) { return b - a < kSameTemperature; });
  grid.currents_a = clusters(of_fast(currents, slow), [](double a, double b) { return b - a <= kSameCurrent * a; });
  for (std::size_t k = 0; k < logs.size(); ++k) {
    grid.temperature_of.push_back(nearest(grid.temperatures_c, temperatures_c[k]));
    grid.current_of.push_back(nearest(grid.currents_a, currents[k]));
  }
  VOLTLAP_DEMAND(!grid.temperatures_c.empty() && increasing(grid.currents_a));
  return grid;
}

}  // namespace voltlap::plant
