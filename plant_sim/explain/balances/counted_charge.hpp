// SPDX-License-Identifier: Apache-2.0
// What a counter of the charge says of the current between two rows: ten rows a second miss how long a pull was
// that began or ended between two of them, and the charge of a whole drive with it.
#pragma once
#include <algorithm>

#include "explain/balances/recording.hpp"

namespace voltlap::plant {

/// Mean current of the pack from the row before until each row [A], discharge positive, by the counter `charge_ah`
/// of the log; NaN where it says nothing (a restart, a missing value). Empty where there is no counter of every
/// row, or one that contradicts the current, or one of steps so coarse that the rows tell more.
[[nodiscard]] Eigen::VectorXd counted_current(const Recording& log);

/// Currents that a log goes between.
struct CurrentRange {
  double low_a = 0.0, high_a = 0.0;
};
[[nodiscard]] CurrentRange usual_range(const Eigen::VectorXd& current_a);

/// Mean square [A^2] of a current that was `before_a` at one row and `now_a` at the next, and `mean_a` on the way: it
/// was switched from one to the other, m^2 + (m - a) (b - m). Where neither can make that mean, it was at the end of
/// the usual range for a while; beyond that it is a straight line to `now_a`.
[[nodiscard]] inline double switched_square(double before_a, double now_a, double mean_a, const CurrentRange& usual) {
  const double least_a = std::min(before_a, now_a), most_a = std::max(before_a, now_a);
  const double from_a = mean_a < least_a ? usual.low_a : mean_a > most_a ? most_a : least_a;
  const double to_a = mean_a > most_a ? usual.high_a : mean_a < least_a ? least_a : most_a;
  const double between = (mean_a - from_a) * (to_a - mean_a), half_a = now_a - mean_a;
  return mean_a * mean_a + (between >= 0.0 ? between : half_a * half_a / 3.0);
}

}  // namespace voltlap::plant
