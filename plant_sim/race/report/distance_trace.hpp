// SPDX-License-Identifier: Apache-2.0
// A run by distance: its main channels every few metres along the course, small enough to stand in the result's JSON,
// so that runs can be laid over each other.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "race/endurance.hpp"

namespace voltlap::plant {

/// A channel of the trace; the first two are where and when.
struct TraceChannel {
  const char *name, *unit;
  int digits;  ///< behind the point, as it is written
  double (*value)(const TimeSample&);
};
[[nodiscard]] std::span<const TraceChannel> trace_channels();

class DistanceTrace {
 public:
  static constexpr double kStep_m = 2.5;
  static constexpr std::size_t kPointsMax = 40'000;  ///< 100 km; longer runs keep every 5 m, 10 m ...

  DistanceTrace();
  /// Samples in the order of time; between two of them every channel is a straight line.
  void add(const TimeSample& sample);
  /// The end of the run: at `end_m` when that is known exactly, else where the last sample was.
  void close(double end_s, std::optional<double> end_m);

  /// One for each channel, all of the same length.
  [[nodiscard]] const std::vector<std::vector<double>>& columns() const { return columns_; }

 private:
  void append(const std::vector<double>& point);
  void halve();

  std::vector<std::vector<double>> columns_;
  std::vector<double> last_;  ///< sample, by channel
  double step_m_ = kStep_m;
};

/// {"distance_m": [...], "time_s": [...], ...}, a line for each channel; a channel that is no number is null.
[[nodiscard]] std::string trace_json(const DistanceTrace& trace);

}  // namespace voltlap::plant
