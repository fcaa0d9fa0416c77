// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/recording_error.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

struct Sums {
  double counted_v2_s = 0.0, counted_s = 0.0, all_v2_s = 0.0, all_s = 0.0, largest_v = 0.0;
  std::vector<std::pair<double, double>> sizes;

  void add(const RecordingResult& file) {
    const RecordingTrace& trace = file.trace;
    VOLTLAP_DEMAND(trace.error_v.size() == trace.weight_s.size());
    for (Index row = 0; row < trace.error_v.size(); ++row) {
      const double weight_s = trace.weight_s(row), square = weight_s * trace.error_v(row) * trace.error_v(row);
      all_v2_s += square;
      all_s += weight_s;
      if (!counts(file, row)) continue;
      counted_v2_s += square;
      counted_s += weight_s;
      sizes.emplace_back(std::abs(trace.error_v(row)), weight_s);
      largest_v = std::max(largest_v, std::abs(trace.error_v(row)));
    }
  }
  [[nodiscard]] RecordingError error() const {
    const auto rms = [](double v2_s, double s) { return s > 0.0 ? std::sqrt(v2_s / s) : 0.0; };
    return {rms(counted_v2_s, counted_s), largest_v, rms(all_v2_s, all_s), most_of(sizes)};
  }
};

}  // namespace

double most_of(std::vector<std::pair<double, double>> size_and_weight) {
  constexpr double kBeyond = 0.001;
  std::sort(size_and_weight.rbegin(), size_and_weight.rend());
  double left = 0.0, weight = 0.0;
  for (const auto& [size, own] : size_and_weight) weight += own;
  for (const auto& [size, own] : size_and_weight) {
    left += own;
    if (left > kBeyond * weight) return size;
  }
  return 0.0;
}

bool counts(const RecordingResult& file, Index row) {
  const bool used = file.used.empty() || file.used.at(static_cast<std::size_t>(row));
  return used && file.trace.weight_s(row) > 0.0;
}

RecordingError error_of(const RecordingResult& file) {
  Sums sums;
  sums.add(file);
  return sums.error();
}

RecordingError error_of(const CellIdentification& identified) {
  Sums sums;
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) sums.add(file);
  }
  return sums.error();
}

}  // namespace voltlap::plant
