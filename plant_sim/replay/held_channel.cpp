// SPDX-License-Identifier: Apache-2.0
#include "replay/held_channel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {

double usual_interval_s(const std::vector<const Channel*>& channels) {
  constexpr double kMost = 0.9;
  std::vector<double> intervals;
  double first_s = std::numeric_limits<double>::infinity(), end_s = -first_s;
  for (const Channel* channel : channels) {
    double last_s = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t k = 0; k < channel->size(); ++k) {
      if (!std::isfinite(channel->value[k])) continue;
      if (std::isfinite(last_s)) intervals.push_back(channel->time_s[k] - last_s);
      last_s = channel->time_s[k];
      first_s = std::min(first_s, last_s);
      end_s = std::max(end_s, last_s);
    }
  }
  // Each was read once: one after the other, over as long as it takes.
  if (intervals.empty()) return std::max(0.0, end_s - first_s);
  return quantile(std::move(intervals), kMost);
}

HeldChannel::HeldChannel(const Channel* channel, double longest_s) : channel_(channel), longest_s_(longest_s) {
  VOLTLAP_DEMAND(longest_s > 0.0);
}

void HeldChannel::advance(double time_s) {
  now_s_ = time_s;
  if (channel_ == nullptr) return;
  for (; next_ < channel_->size() && channel_->time_s[next_] <= time_s; ++next_) {
    if (!std::isfinite(channel_->value[next_])) continue;
    seen_ = true;
    value_ = channel_->value[next_];
    sample_s_ = channel_->time_s[next_];
  }
}

double HeldChannel::first_s() const {
  for (std::size_t k = 0; channel_ != nullptr && k < channel_->size(); ++k) {
    if (std::isfinite(channel_->value[k])) return channel_->time_s[k];
  }
  return std::numeric_limits<double>::infinity();
}

double HeldChannel::last_s() const {
  for (std::size_t k = channel_ == nullptr ? 0 : channel_->size(); k-- > 0;) {
    if (std::isfinite(channel_->value[k])) return channel_->time_s[k];
  }
  return -std::numeric_limits<double>::infinity();
}

double value_at(const Channel& channel, double time_s) {
  const auto after = std::upper_bound(channel.time_s.begin(), channel.time_s.end(), time_s);
  for (auto k = static_cast<std::size_t>(after - channel.time_s.begin()); k-- > 0;) {
    if (std::isfinite(channel.value[k])) return channel.value[k];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace voltlap::plant
