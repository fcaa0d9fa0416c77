// SPDX-License-Identifier: Apache-2.0
// From many disturbed times of the same work to one number and how far it can be trusted.
//
//   quickest  = sum over the stretches of the least time that any repetition took for the stretch
//   relative  = quickest / operations / reference,  reference = lowest decile of the reference kernel in the whole run
//   interval  = 1 % to 99 % of `relative` over random halves of the repetitions, and down to
//               the sum of each quickest stretch over the reference kernel at that very moment
// Whatever disturbs a time on a shared machine makes it longer: the least is the one to compare. Dividing by the
// reference takes out how fast the machine was that day. The last bound is for a machine that was busy through all
// repetitions of a stretch: the kernel beside it was then slow as well, and the row is no evidence of a slowdown.
#pragma once
#include <vector>

#include "stopwatch.hpp"

namespace voltlap::benchmarks {

/// One row's repetitions, each with the same stretches.
using Repetitions = std::vector<std::vector<Stretch>>;

struct Estimate {
  double ns = 0.0;        ///< of one operation, quickest
  double relative = 0.0;  ///< of one operation, in units of the reference kernel
  double low = 0.0, high = 0.0;  ///< interval of `relative`
  double spread = 0.0;    ///< interquartile range over median of the repetitions' whole times
};

/// Lowest decile of the reference kernel [ns] over all rows of a run.
[[nodiscard]] double reference_time_ns(const std::vector<Repetitions>& rows);

/// `operations` in one repetition. Throws std::invalid_argument when there is no repetition or they differ in length.
[[nodiscard]] Estimate estimate(const Repetitions& repetitions, double operations, double reference_ns);

}  // namespace voltlap::benchmarks
