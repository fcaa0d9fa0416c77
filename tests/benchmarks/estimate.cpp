// SPDX-License-Identifier: Apache-2.0
#include "estimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

namespace voltlap::benchmarks {
namespace {

constexpr int kHalves = 400;

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], place - static_cast<double>(below));
}

/// Each stretch where it was quickest among the repetitions chosen, summed.
struct Quickest {
  double ns = 0.0;
  double beside = 0.0;  ///< in units of the reference kernel at that moment
};

Quickest quickest(const Repetitions& repetitions, const std::vector<std::size_t>& chosen) {
  Quickest sum;
  for (std::size_t k = 0; k < repetitions.front().size(); ++k) {
    const auto least = *std::min_element(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
      return repetitions[a][k].work_ns < repetitions[b][k].work_ns;
    });
    const Stretch& stretch = repetitions[least][k];
    sum.ns += stretch.work_ns;
    sum.beside += stretch.work_ns / stretch.reference_ns;
  }
  return sum;
}

double spread_of(const Repetitions& repetitions) {
  std::vector<double> whole;
  for (const auto& stretches : repetitions) {
    whole.push_back(std::accumulate(stretches.begin(), stretches.end(), 0.0,
                                    [](double sum, const Stretch& s) { return sum + s.work_ns; }));
  }
  return (quantile(whole, 0.75) - quantile(whole, 0.25)) / quantile(whole, 0.5);
}

}  // namespace

double reference_time_ns(const std::vector<Repetitions>& rows) {
  std::vector<double> times;
  for (const Repetitions& repetitions : rows) {
    for (const auto& stretches : repetitions) {
      for (const Stretch& stretch : stretches) times.push_back(stretch.reference_ns);
    }
  }
  if (times.empty()) throw std::invalid_argument("nothing was measured");
  return quantile(times, 0.1);
}

Estimate estimate(const Repetitions& repetitions, double operations, double reference_ns) {
  if (repetitions.empty() || repetitions.front().empty()) throw std::invalid_argument("nothing was measured");
  for (const auto& stretches : repetitions) {
    if (stretches.size() != repetitions.front().size())
      throw std::invalid_argument("repetitions did not do the same work");
  }
  std::vector<std::size_t> order(repetitions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const Quickest all = quickest(repetitions, order);

  std::mt19937 random;  // the same halves for every row and run
  const std::size_t half = std::max<std::size_t>(1, order.size() / 2);
  std::vector<double> of_halves;
  for (int i = 0; i < kHalves; ++i) {
    std::shuffle(order.begin(), order.end(), random);
    of_halves.push_back(quickest(repetitions, {order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half)}).ns);
  }
  const double unit = operations * reference_ns;
  return {.ns = all.ns / operations,
          .relative = all.ns / unit,
          .low = std::min(quantile(of_halves, 0.01) / unit, all.beside / operations),
          .high = quantile(of_halves, 0.99) / unit,
          .spread = spread_of(repetitions)};
}

}  // namespace voltlap::benchmarks
