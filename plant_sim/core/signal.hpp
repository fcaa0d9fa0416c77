// SPDX-License-Identifier: Apache-2.0
// What is asked of a list of readings again and again. Readings that are no numbers do not count.
#pragma once
#include <span>
#include <vector>

namespace voltlap::plant {

/// The value below which `share` (0..1) of the values lie: the element at floor(share n) in order, the last for 1.
/// 0 without any value.
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// The upper of the two in the middle when their number is even; 0 without any value.
[[nodiscard]] double median(std::vector<double> values);

/// sqrt(mean of squares); 0 without any value.
[[nodiscard]] double rms(std::span<const double> values);

/// Smallest difference between two readings that differ by more than `same`: the step of a coarse sensor. 0 when no
/// two differ.
[[nodiscard]] double smallest_step(std::vector<double> readings, double same = 1e-6);

/// Differences between neighbours: intervals of a time, for one. Empty for fewer than two.
[[nodiscard]] std::vector<double> differences(const std::vector<double>& values);

}  // namespace voltlap::plant
