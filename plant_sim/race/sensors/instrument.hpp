// SPDX-License-Identifier: Apache-2.0
// One instrument with its errors. The lag is exact for a truth that is straight between two periods:
//   y_k = a y_{k-1} + x_k - a x_{k-1} - (x_k - x_{k-1}) (tau / dt) (1 - a),  a = exp(-dt / tau)
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/demand.hpp"
#include "core/instrument_parameters.hpp"

namespace voltlap::plant {

class Instrument {
 public:
  explicit Instrument(const ReadingErrors& errors = {}) : errors_(errors), off_(errors == ReadingErrors{}) {
    VOLTLAP_DEMAND(errors.min < errors.max && errors.delay_s >= 0.0 && errors.lag_s >= 0.0);
    const auto periods = static_cast<std::size_t>(std::lround(errors.delay_s / kInstrumentPeriod_s));
    if (moves()) past_.resize(periods + 1);
  }

  /// It must follow the truth in every period.
  [[nodiscard]] bool moves() const { return errors_.delay_s > 0.0 || errors_.lag_s > 0.0; }

  /// Once in every period: the truth as it arrives. Before the first there was nothing else.
  double follow(double truth) {
    if (!moves()) return truth;
    if (!begun_) {
      std::fill(past_.begin(), past_.end(), truth);
      lagged_ = before_ = truth;
      begun_ = true;
    }
    advance_lag(truth);
    past_[next_] = lagged_;
    next_ = (next_ + 1) % past_.size();
    arrived_ = past_[next_];
    return arrived_;
  }
  /// What arrived last; the truth of an instrument that does not move.
  [[nodiscard]] double arrived(double truth) const { return moves() ? arrived_ : truth; }

  [[nodiscard]] double scaled(double arrived) const {
    return off_ ? arrived : errors_.gain * arrived + errors_.offset;
  }
  [[nodiscard]] double clipped(double reading) const {
    return off_ ? reading : std::clamp(reading, errors_.min, errors_.max);
  }
  /// All of it, for a sensor without noise that is read in every period.
  double read(double truth) { return off_ ? truth : clipped(scaled(follow(truth))); }

 private:
  void advance_lag(double truth) {
    if (errors_.lag_s > 0.0) {
      const double a = std::exp(-kInstrumentPeriod_s / errors_.lag_s);
      const double bend = (truth - before_) * errors_.lag_s / kInstrumentPeriod_s * (1.0 - a);
      lagged_ = a * lagged_ + truth - a * before_ - bend;
    } else {
      lagged_ = truth;
    }
    before_ = truth;
  }

  ReadingErrors errors_;
  bool off_, begun_ = false;
  double lagged_ = 0.0, before_ = 0.0, arrived_ = 0.0;
  std::vector<double> past_;  ///< a ring, the oldest at next_
  std::size_t next_ = 0;
};

}  // namespace voltlap::plant
