// SPDX-License-Identifier: Apache-2.0
// When a rest is over: no cell rises (after a charge: falls) faster than a limit (reference study, 2016,
// section 5.1: 1 mV/min), judged from the instruments' readings as on a real bench. The mean of the newer half of a
// window minus the mean of its older half, per minute, averages noise and steps: 480 readings of 1.5 mV noise in a
// half leave 0.1 mV. It sees the rise of half a window ago, so a rest ends about that much late.
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/demand.hpp"

namespace voltlap::plant {

class RelaxationRule {
 public:
  RelaxationRule(std::size_t cells, double window_s, double rate_hz)
      : half_(std::max<std::size_t>(2, static_cast<std::size_t>(0.5 * window_s * rate_hz + 0.5))),
        per_minute_(60.0 * rate_hz / static_cast<double>(half_)),
        readings_(cells, std::vector<double>(2 * half_)),
        older_(cells),
        newer_(cells) {
    VOLTLAP_DEMAND(cells > 0 && window_s > 0.0 && rate_hz > 0.0);
  }

  /// A rest begins.
  void begin() {
    count_ = 0;
    std::fill(older_.begin(), older_.end(), 0.0);
    std::fill(newer_.begin(), newer_.end(), 0.0);
  }

  void add(std::span<const double> voltages) {
    const std::size_t at = count_ % (2 * half_), middle = (count_ + half_) % (2 * half_);
    for (std::size_t cell = 0; cell < readings_.size(); ++cell) {
      std::vector<double>& ring = readings_[cell];
      if (count_ >= 2 * half_) older_[cell] -= ring[at];
      if (count_ >= half_) {
        older_[cell] += ring[middle];
        newer_[cell] -= ring[middle];
      }
      newer_[cell] += ring[at] = voltages[cell];
    }
    ++count_;
  }

  /// Fastest change of any cell [V/min]; only known when the window is full.
  [[nodiscard]] bool known() const { return count_ >= 2 * half_; }
  [[nodiscard]] double rate_v_per_min() const {
    double most = 0.0;
    for (std::size_t cell = 0; cell < newer_.size(); ++cell)
      most = std::max(most, std::abs(newer_[cell] - older_[cell]));
    return most / static_cast<double>(half_) * per_minute_;
  }

 private:
  std::size_t half_;  ///< readings in half a window
  double per_minute_;
  std::vector<std::vector<double>> readings_;  ///< [cell] ring of a whole window
  std::vector<double> older_, newer_;          ///< sums over the halves
  std::size_t count_ = 0;
};

}  // namespace voltlap::plant
