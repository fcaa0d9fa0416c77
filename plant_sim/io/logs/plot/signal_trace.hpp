// SPDX-License-Identifier: Apache-2.0
// The points that a chart of a signal is drawn of. Where a value repeats, only the ends of the stretch are kept, which
// loses nothing; where that leaves too many, time is divided into buckets and each keeps its lowest and its highest
// sample with their own times. No extreme is lost, and no line crosses a gap.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "io/logs/plot/signal_course.hpp"

namespace voltlap::plant {

class SignalTrace {
 public:
  /// `course` is of the same samples, and complete.
  SignalTrace(const SignalCourse& course, std::size_t most_points);

  /// As SignalCourse::add.
  void add(double time_s, double value);
  void finish();

  [[nodiscard]] const std::vector<double>& time_s() const { return time_s_; }
  [[nodiscard]] const std::vector<double>& value() const { return value_; }
  /// Points that are not joined to the one before: the signal begins, or begins again.
  [[nodiscard]] const std::vector<std::size_t>& begins() const { return begins_; }
  /// Width of a bucket [s]; 0: every sample is there.
  [[nodiscard]] double bucket_s() const { return bucket_s_; }
  [[nodiscard]] std::size_t gaps() const { return gaps_; }

 private:
  struct Point {
    double time_s, value;
  };
  struct Bucket {
    long number;
    Point low, high;
  };
  void gather(const Point& point);
  void flush();
  void keep(const Point& point);
  void end_piece();
  void push(const Point& point);

  double gap_s_, first_s_, bucket_s_ = 0.0;
  bool stepped_;
  std::optional<Bucket> bucket_;
  std::optional<Point> held_;  ///< the latest sample, not kept so far
  std::optional<double> last_s_;
  bool known_ = false;   ///< there was a sample, and no gap since
  bool joined_ = false;  ///< the next point is joined to the last one
  std::size_t gaps_ = 0;
  std::vector<double> time_s_, value_;
  std::vector<std::size_t> begins_;
};

}  // namespace voltlap::plant
