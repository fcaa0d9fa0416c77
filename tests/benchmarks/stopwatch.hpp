// SPDX-License-Identifier: Apache-2.0
// Times a piece of work that is always the same, in stretches of some milliseconds with the reference kernel between
// them: a machine that slows down, slows both. Processor time of this thread, so that waiting for a core does not
// count.
#pragma once
#include <vector>

namespace voltlap::benchmarks {

struct Stretch {
  double work_ns;
  double reference_ns;  ///< mean of the reference kernel before and after
};

class Stopwatch {
 public:
  /// Work begins; measures the reference first.
  void start();
  /// A stretch ends here and the next one begins.
  void split();

  [[nodiscard]] const std::vector<Stretch>& stretches() const { return stretches_; }

 private:
  std::vector<Stretch> stretches_;
  double reference_ns_ = 0.0, resumed_ns_ = 0.0;
};

}  // namespace voltlap::benchmarks
