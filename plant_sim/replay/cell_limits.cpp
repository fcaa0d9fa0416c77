// SPDX-License-Identifier: Apache-2.0
#include "replay/cell_limits.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {

void CellLimits::sample(double time_s, std::size_t cell, double voltage_v) {
  if (!std::isfinite(voltage_v)) return;
  if (cell >= cells_.size()) cells_.resize(cell + 1);
  Open& open = cells_[cell];
  const bool low = voltage_v < min_v_, high = voltage_v > max_v_;
  const double limit_v = low ? min_v_ : max_v_;
  if ((!low && !high) || (open.running && open.stretch.limit_v != limit_v)) close(open);
  if (!low && !high) return;
  if (!open.running) open.stretch = {time_s, time_s, static_cast<int>(cell) + 1, voltage_v, limit_v,
                                      time_s};
  open.running = true;
  open.stretch.until_s = time_s;
  const bool worse = std::abs(voltage_v - limit_v) > std::abs(open.stretch.voltage_v - limit_v);
  if (!worse) return;
  open.stretch.voltage_v = voltage_v;
  open.stretch.worst_s = time_s;
}

void CellLimits::close(Open& open) {
  if (open.running) into_.push_back(open.stretch);
  open.running = false;
}

void CellLimits::finish() {
  for (Open& open : cells_) close(open);
  std::stable_sort(into_.begin(), into_.end(),
                   [](const LimitViolation& a, const LimitViolation& b) { return a.time_s < b.time_s; });
}

}  // namespace voltlap::plant
