// SPDX-License-Identifier: Apache-2.0
// Samples that tests draw or write down, and what a signal of them does.
#pragma once
#include <utility>
#include <vector>

#include "io/logs/plot/signal_course.hpp"

namespace voltlap::plant::test {

using Samples = std::vector<std::pair<double, double>>;  // time [s], value

inline SignalCourse course_of(const Samples& samples) {
  SignalCourse out;
  for (const auto& [time_s, value] : samples) out.add(time_s, value);
  return out;
}

/// Values a tenth of a second apart.
inline SignalCourse course_of_values(const std::vector<double>& values) {
  Samples samples;
  for (const double value : values) samples.emplace_back(0.1 * static_cast<double>(samples.size()), value);
  return course_of(samples);
}

}  // namespace voltlap::plant::test
