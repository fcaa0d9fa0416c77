// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_course.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kShortest = 1e-6;  // s; first class of intervals
constexpr int kMostDecimals = 6;
constexpr std::size_t kEnough = 20;  // changes that make a habit

bool has_decimals(double value, int decimals) {
  const double scaled = value * std::pow(10.0, decimals);
  return std::abs(scaled - std::round(scaled)) > 1e-9 * std::max(1.0, std::abs(scaled));
}

}  // namespace

void SignalCourse::add(double time_s, double value) {
  VOLTLAP_DEMAND(std::isfinite(time_s));
  if (!std::isfinite(value)) {
    ++missing_;
    return;
  }
  if (samples_ == 0) {
    first_s_ = low_at_s_ = high_at_s_ = time_s;
    low_ = high_ = value;
    add_change(value);
    changes_ = 0;
  } else {
    VOLTLAP_DEMAND(time_s >= last_s_);
    add_interval(time_s - last_s_);
    if (value != last_) add_change(value);
  }
  if (value < low_) low_ = value, low_at_s_ = time_s;
  if (value > high_) high_ = value, high_at_s_ = time_s;
  last_s_ = time_s;
  last_ = value;
  ++samples_;
}

/// A value other than the last one.
void SignalCourse::add_change(double value) {
  if (samples_ > 0) {
    const double step = value - last_;
    if (changes_ == 0) step_ = step;
    if (std::abs(step - step_) <= 1e-9 * std::abs(step_)) ++same_steps_;
    travel_ += std::abs(step);
  }
  ++changes_;
  while (decimals_ < kMostDecimals && has_decimals(value, decimals_)) ++decimals_;
  if (different_ > kFew) return;
  const auto end = values_.begin() + static_cast<std::ptrdiff_t>(different_);
  if (std::find(values_.begin(), end, value) != end) return;
  if (different_ < kFew) values_[different_] = value;
  ++different_;
}

void SignalCourse::add_interval(double interval_s) {
  const int power = interval_s > kShortest ? std::ilogb(interval_s / kShortest) + 1 : 0;
  ++intervals_[static_cast<std::size_t>(std::min(power, static_cast<int>(intervals_.size()) - 1))];
}

/// Upper end of the class of intervals below which that part of them lies.
double SignalCourse::interval_quantile(double part) const {
  VOLTLAP_DEMAND(within(part, 0.0, 1.0));
  if (samples_ < 2) return 0.0;
  const double wanted = part * static_cast<double>(samples_ - 1);
  double seen = 0.0;
  std::size_t k = 0;
  for (; k + 1 < intervals_.size(); ++k) {
    seen += intervals_[k];
    if (seen >= wanted) break;
  }
  return std::ldexp(kShortest, static_cast<int>(k));
}

double SignalCourse::usual_interval_s() const { return interval_quantile(0.5) * 0.75; }

double SignalCourse::gap_s() const {
  // What is sent on change has no habit: only an interval far beyond nearly all others is a gap.
  constexpr double kUsual = 0.95, kBeyond = 8.0, kLeast = 0.2;  // -, -, s
  return std::max(kBeyond * interval_quantile(kUsual), kLeast);
}

bool SignalCourse::is_stepped() const {
  constexpr std::size_t kSeldom = 10;  // samples for each change
  return different_ <= kFew || changes_ * kSeldom < samples_;
}

bool SignalCourse::is_counter() const {
  // One of 2 bits steps back at every fourth sample.
  constexpr double kNearlyAll = 0.9, kMost = 0.7;
  const bool always = static_cast<double>(changes_) > kNearlyAll * static_cast<double>(samples_);
  const double same = static_cast<double>(same_steps_) / static_cast<double>(std::max<std::size_t>(changes_, 1));
  return changes_ >= kEnough && same >= (always && different_ <= kFew ? kMost : kNearlyAll);
}

bool SignalCourse::is_noise() const {
  // Two values drawn at random from a range are a third of it apart on average.
  constexpr double kFar = 0.25;
  return changes_ >= kEnough && different_ > kFew && 2 * changes_ > samples_ &&
         travel_ > kFar * range() * static_cast<double>(changes_);
}

}  // namespace voltlap::plant
