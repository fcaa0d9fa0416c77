// SPDX-License-Identifier: Apache-2.0
// What sound logs show of a cause: it is fitted in each reference as in the log, and is worth a word only where the
// log lies outside of what references give.
//
//   t = (size - mean) / sqrt(s^2 (1 + 1/(n + 1)) + se^2),   s^2 = (nu s0^2 + sum (size_r - mean)^2) / (nu + n)
//
// over n references; s0 is the size that makes a small part of a practical effect, and mean is drawn towards
// nothing by one reference that shows none. A heavy-tailed t with nu + n degrees of freedom decides.
#pragma once
#include <vector>

#include "explain/fit/search.hpp"

namespace voltlap::explain {

/// What references make of one number of a cause, in its own unit.
struct Habit {
  double mean = 0.0, spread = 0.0;  ///< spread: standard deviation of a further sound log
  int references = 0;
};

struct Unlike {
  bool is = false;  ///< outside of what sound logs show
  double t = 0.0, least = 0.0;
  Habit habit;
};

/// Is this member of a set unlike what `references`, families of sound logs, show of it? `alike`: how many of its
/// kind were looked at.
[[nodiscard]] Unlike unlike_of(const Family& family, const Set& set, std::size_t member,
                               const std::vector<const Family*>& references, double alike);

/// Two-sided critical value of Student's t.
[[nodiscard]] double critical_t(double probability, double freedom);

}  // namespace voltlap::explain
