// SPDX-License-Identifier: Apache-2.0
// What a stage was given and what it gives, checked where it is made and again where it is used, in every build. A
// demand that is not met is a defect of the program; what a person can mend is an InputError.
#pragma once
#include <cmath>
#include <cstddef>

namespace voltlap::plant {

/// Throws std::logic_error with condition and place: the program ends with "found a defect of the program" and code 70.
[[noreturn]] void demand_failed(const char* condition, const char* file, int line);

/// True when every value is a number; of an empty range too.
template <class Range>
[[nodiscard]] bool all_finite(const Range& values) {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

/// True when each value is larger than the one before: time, distance, breakpoints. NaN never is.
template <class Range>
[[nodiscard]] bool increasing(const Range& values) {
  bool first = true;
  double before = 0.0;
  for (const double value : values) {
    if (!first && !(value > before)) return false;
    before = value;
    first = false;
  }
  return true;
}

/// True for a number in [low, high].
[[nodiscard]] inline bool within(double value, double low, double high) { return value >= low && value <= high; }

}  // namespace voltlap::plant

#define VOLTLAP_DEMAND(condition) \
  ((condition) ? static_cast<void>(0) : ::voltlap::plant::demand_failed(#condition, __FILE__, __LINE__))
