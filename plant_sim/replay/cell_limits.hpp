// SPDX-License-Identifier: Apache-2.0
// Stretches in which a cell was outside of its voltage limits, from its samples.
#pragma once
#include <vector>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

class CellLimits {
 public:
  CellLimits(double min_v, double max_v, std::vector<LimitViolation>& into)
      : min_v_(min_v), max_v_(max_v), into_(into) {}

  /// `cell` from 0; samples of one cell come in their order.
  void sample(double time_s, std::size_t cell, double voltage_v);
  /// Ends what is still open, and sorts by time.
  void finish();

 private:
  struct Open {
    bool running = false;
    LimitViolation stretch{};
  };
  void close(Open& open);

  double min_v_, max_v_;
  std::vector<LimitViolation>& into_;
  std::vector<Open> cells_;
};

}  // namespace voltlap::plant
