// SPDX-License-Identifier: Apache-2.0
#include "io/logs/channel_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kGapTimes = 10.0, kGapLeast = 0.5;  // of the usual interval; s
constexpr double kUsual = 0.9;                       // of the intervals: a recorder may be slower at rest

}  // namespace

ChannelBuilder::ChannelBuilder(DriveLog& log, std::string role, const RoleSource& source, std::string described)
    : log_(log), source_(source), range_(role_range(role)) {
  range_.min = source.min.value_or(range_.min);
  range_.max = source.max.value_or(range_.max);
  channel_.role = std::move(role);
  channel_.source = std::move(described);
}

void ChannelBuilder::extend(double time_s, const char* reason) {
  if (!open_ || stretches_.back().reason != reason) {
    stretches_.push_back({channel_.role, time_s, time_s, reason, 0});
    open_ = true;
  }
  stretches_.back().end_s = time_s;
  ++stretches_.back().count;
}

void ChannelBuilder::mask(double time_s, const char* reason) {
  channel_.time_s.push_back(time_s);
  channel_.value.push_back(kNothing);
  extend(time_s, reason);
  LogDefect& defect = defects_[reason];
  if (defect.count++ == 0) defect.first_s = time_s;
}

void ChannelBuilder::add(double time_s, double recorded) {
  if (!std::isfinite(time_s)) return;
  if (!channel_.time_s.empty() && time_s < channel_.time_s.back()) {
    LogDefect& defect = defects_["time goes back"];
    if (defect.count++ == 0) defect.first_s = time_s;
    ++channel_.left_out;
    return;
  }
  const double value = recorded * source_.scale + source_.offset;
  if (!std::isfinite(value)) return mask(time_s, "no number");
  // A code of a signal has been multiplied with its scale: 65535 x 0.0001 V is 6.5535 V but for the last bit.
  const auto is_code = [&](double code) { return std::abs(recorded - code) <= 1e-9 * std::max(1.0, std::abs(code)); };
  if (std::any_of(source_.invalid.begin(), source_.invalid.end(), is_code)) return mask(time_s, "invalid code");
  if (value < range_.min || value > range_.max) return mask(time_s, "impossible value");
  channel_.time_s.push_back(time_s);
  channel_.value.push_back(value);
  ++usable_;
  open_ = false;
}

void ChannelBuilder::add_lost_frames(double from_s, double to_s, std::size_t frames) {
  LogDefect& defect = defects_["lost frames by the counter"];
  if (defect.count == 0) defect.first_s = from_s;
  defect.count += frames;
  stretches_.push_back({channel_.role, from_s, to_s, "lost frames by the counter", 0});
  open_ = false;
}

void ChannelBuilder::finish() {
  VOLTLAP_DEMAND(channel_.time_s.size() == channel_.value.size() && usable_ <= channel_.value.size());
  const double usual = quantile(differences(channel_.time_s), kUsual);
  const double gap = std::max(kGapLeast, kGapTimes * usual);
  for (std::size_t k = 1; k < channel_.time_s.size(); ++k) {
    if (channel_.time_s[k] - channel_.time_s[k - 1] <= gap) continue;
    stretches_.push_back({channel_.role, channel_.time_s[k - 1], channel_.time_s[k], "gap", 0});
    LogDefect& defect = defects_["gap"];
    if (defect.count++ == 0) defect.first_s = channel_.time_s[k - 1];
  }
  std::stable_sort(stretches_.begin(), stretches_.end(),
                   [](const MaskedStretch& a, const MaskedStretch& b) { return a.start_s < b.start_s; });
  if (channel_.time_s.empty()) {
    log_.absent.push_back(channel_.role);
    return;
  }
  if (usable_ == 0) {
    log_.defects.push_back(
        {"no usable value", channel_.role, channel_.time_s.size(), 0.0,
         fmt::format("{} ({}): none of {} samples is a measurement: a padding slot, a sensor that "
                     "is not there, or a wrong unit; left out",
                     channel_.role, channel_.source, channel_.time_s.size())});
    return;
  }
  for (auto& [kind, defect] : defects_) {
    defect.kind = kind;
    defect.channel = channel_.role;
    defect.text = fmt::format("{} ({}): {} of {} samples: {}, first at {:.3f} s", channel_.role, channel_.source,
                              defect.count, channel_.time_s.size() + channel_.left_out, kind, defect.first_s);
    if (kind == "gap")
      defect.text = fmt::format("{} ({}): {} gaps, first at {:.3f} s", channel_.role, channel_.source, defect.count,
                                defect.first_s);
    log_.defects.push_back(defect);
  }
  log_.masked.insert(log_.masked.end(), stretches_.begin(), stretches_.end());
  log_.channels[channel_.role] = std::move(channel_);
}

}  // namespace voltlap::plant
