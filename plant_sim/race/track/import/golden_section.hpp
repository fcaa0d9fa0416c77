// SPDX-License-Identifier: Apache-2.0
// The place of the least value of a function of one variable that falls and then rises.
#pragma once
#include <cmath>

namespace voltlap::plant {

/// The least of f in [low, high] to within `width`, by golden section.
template <class Function>
double golden_section(double low, double high, double width, const Function& f) {
  const double share = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = high - share * (high - low), b = low + share * (high - low), at_a = f(a), at_b = f(b);
  while (high - low > width) {
    if (at_a < at_b) {
      high = b;
      b = a, at_b = at_a;
      a = high - share * (high - low), at_a = f(a);
    } else {
      low = a;
      a = b, at_a = at_b;
      b = low + share * (high - low), at_b = f(b);
    }
  }
  return 0.5 * (low + high);
}

}  // namespace voltlap::plant
