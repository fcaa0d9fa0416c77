// SPDX-License-Identifier: Apache-2.0
#include "core/signal.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/demand.hpp"

namespace voltlap::plant {

double quantile(std::vector<double> values, double share) {
  VOLTLAP_DEMAND(within(share, 0.0, 1.0));
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return 0.0;
  const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(place, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double rms(std::span<const double> values) {
  double square = 0.0, count = 0.0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    square += v * v;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

double smallest_step(std::vector<double> readings, double same) {
  VOLTLAP_DEMAND(same >= 0.0);
  std::erase_if(readings, [](double v) { return !std::isfinite(v); });
  std::sort(readings.begin(), readings.end());
  double step = 0.0;
  for (std::size_t k = 1; k < readings.size(); ++k) {
    const double rise = readings[k] - readings[k - 1];
    if (rise > same) step = step > 0.0 ? std::min(step, rise) : rise;
  }
  return step;
}

std::vector<double> differences(const std::vector<double>& values) {
  std::vector<double> out;
  for (std::size_t k = 1; k < values.size(); ++k) out.push_back(values[k] - values[k - 1]);
  return out;
}

}  // namespace voltlap::plant
