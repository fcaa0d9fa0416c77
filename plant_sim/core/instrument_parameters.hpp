// SPDX-License-Identifier: Apache-2.0
// The error of one instrument, between the truth and what its frame says:
//   x' = lag and delay of the truth;  reading = clip(gain x' + offset, min, max)
// Noise and steps of a sensor, where it has them, come before the clip. Each part is off at its default.
#pragma once
#include <limits>
#include <optional>

namespace voltlap::plant {

struct ReadingErrors {
  double offset = 0.0;   ///< in the unit of the reading
  double gain = 1.0;     ///< [1]
  double delay_s = 0.0;  ///< [s] whole periods of the sensors
  double lag_s = 0.0;    ///< [s] time constant, first order
  double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();

  bool operator==(const ReadingErrors&) const = default;
};

/// Of one channel among many: what is given stands in the place of what all of them have.
struct ChannelErrors {
  std::optional<double> offset, gain, delay_s, lag_s, min, max;

  [[nodiscard]] ReadingErrors over(const ReadingErrors& all) const {
    return {offset.value_or(all.offset), gain.value_or(all.gain), delay_s.value_or(all.delay_s),
            lag_s.value_or(all.lag_s), min.value_or(all.min), max.value_or(all.max)};
  }
};

/// The sensors send and are read on this clock.
inline constexpr double kInstrumentPeriod_s = 0.01;

}  // namespace voltlap::plant
