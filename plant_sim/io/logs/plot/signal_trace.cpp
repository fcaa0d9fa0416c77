// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_trace.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

SignalTrace::SignalTrace(const SignalCourse& course, std::size_t most_points)
    : gap_s_(course.gap_s()), first_s_(course.first_s()), stepped_(course.is_stepped()) {
  VOLTLAP_DEMAND(most_points >= 16);
  const std::size_t lossless = (stepped_ ? 1 : 2) * course.changes() + 2;
  if (lossless <= most_points) return;
  // Two points a bucket, and a third where a repeated value ends.
  bucket_s_ = 3.0 * (course.last_s() - course.first_s()) / static_cast<double>(most_points);
}

void SignalTrace::add(double time_s, double value) {
  if (!std::isfinite(value)) {
    if (known_) ++gaps_;
    end_piece();
    return;
  }
  VOLTLAP_DEMAND(!last_s_ || time_s >= *last_s_);
  if (known_ && time_s - *last_s_ > gap_s_) {
    ++gaps_;
    end_piece();
  }
  last_s_ = time_s;
  known_ = true;
  gather({time_s, value});
}

void SignalTrace::gather(const Point& point) {
  if (bucket_s_ == 0.0) return keep(point);
  const long number = std::lround(std::floor((point.time_s - first_s_) / bucket_s_));
  if (bucket_ && bucket_->number != number) flush();
  if (!bucket_) {
    bucket_ = {number, point, point};
    return;
  }
  if (point.value < bucket_->low.value) bucket_->low = point;
  if (point.value > bucket_->high.value) bucket_->high = point;
}

void SignalTrace::flush() {
  if (!bucket_) return;
  const auto [number, low, high] = *bucket_;
  bucket_.reset();
  keep(low.time_s <= high.time_s ? low : high);
  if (low.value != high.value) keep(low.time_s <= high.time_s ? high : low);
}

/// Of a value that repeats the first sample, and the last one when the next differs: a line between samples leaves
/// there, not earlier.
void SignalTrace::keep(const Point& point) {
  if (joined_ && value_.back() == point.value) {
    held_ = point;
    return;
  }
  if (held_ && !stepped_) push(*held_);
  held_.reset();
  push(point);
}

/// The signal is not known from here on; what was known lasts up to its last sample.
void SignalTrace::end_piece() {
  flush();
  if (held_) push(*held_);
  held_.reset();
  known_ = joined_ = false;
}

void SignalTrace::push(const Point& point) {
  VOLTLAP_DEMAND(time_s_.empty() || point.time_s >= time_s_.back());
  if (!joined_) begins_.push_back(time_s_.size());
  joined_ = true;
  time_s_.push_back(point.time_s);
  value_.push_back(point.value);
}

void SignalTrace::finish() {
  end_piece();
  VOLTLAP_DEMAND(time_s_.size() == value_.size());
}

}  // namespace voltlap::plant
