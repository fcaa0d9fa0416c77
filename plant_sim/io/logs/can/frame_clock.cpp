// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/frame_clock.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kAhead = 4096;                // frames looked at before one is judged
constexpr std::size_t kWitnesses = 4;               // frames after one that say where it belongs
constexpr double kJitter = 0.05;                    // s; a step back that small is order, whatever follows
constexpr double kDay = 86400.0, kAbsolute = 1e8;   // s; a stamp beyond counts from 1970
constexpr double kLatest = 1e11, kEarliest = -1e6;  // s; beyond lies no recording
constexpr double kNearZero = 10.0;                  // s; a clock that starts anew
constexpr double kSlow = 1.0 / 32;                  // weight of an interval in the usual one

// Counters that recorders use, full width [s]: 16, 24, 31 and 32 bits of ms, 31 and 32 bits of us, 32 bits of 10 and
// 100 us, a day.
constexpr double kSixteenBits = 65.536;
constexpr std::array kWidths{kSixteenBits, 2147.483648, 4294.967296, 16777.216,  42949.67296,
                             86400.0,      429496.7296, 2147483.648, 4294967.296};

std::string clock_text(double stamp_s) {
  if (stamp_s < kAbsolute) return fmt::format("{:.3f} s", stamp_s);
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(stamp_s)));
}

}  // namespace

std::vector<std::string> clock_notes(const std::vector<ClockPart>& parts, const char* line) {
  constexpr std::size_t kShown = 8;
  std::vector<std::string> out;
  if (parts.size() < 2) return out;
  for (std::size_t k = 1; k < std::min(parts.size(), kShown); ++k) {
    const bool anew = parts[k].begin == ClockPart::Begin::kAnew;
    out.push_back(fmt::format("{} {}: the clock {} from {} to {}: joined, {}", line, parts[k].first_line,
                              anew ? "starts anew," : "was set,", clock_text(parts[k - 1].recorded_end_s),
                              clock_text(parts[k].recorded_begin_s),
                              anew ? "what lies between is not known" : "one usual interval between"));
  }
  out.push_back(fmt::format("{} parts of the clock in all", parts.size()));
  return out;
}

void CanDefects::add(const char* kind, std::size_t line, double time_s, bool used) {
  auto at =
      std::find_if(defects_.begin(), defects_.end(), [&](const CanDefect& defect) { return defect.kind == kind; });
  if (at == defects_.end()) at = defects_.insert(at, {kind, 0, line, time_s, time_s, used});
  ++at->count;
  at->last_s = time_s;
}

void FrameQueue::pop() {
  VOLTLAP_DEMAND(begin_ < frames_.size());
  constexpr std::size_t kWorthMoving = 4096;
  ++begin_;
  if (begin_ < kWorthMoving || 2 * begin_ < frames_.size()) return;
  frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
}

void FrameClock::push() {
  VOLTLAP_DEMAND(!finished_);
  ahead_.push() = slot_;
}

/// A late frame goes behind those of the same time that came in order.
bool FrameClock::late_is_first() const {
  return !late_.empty() && (ordered_.empty() || late_.begin()->first < ordered_.front().time_s);
}

bool FrameClock::pop(RecordedFrame& out) {
  const auto settled = [&] {
    const bool late = late_is_first();
    if (!late && ordered_.empty()) return false;
    const double first_s = late ? late_.begin()->first : ordered_.front().time_s;
    return !(first_s > newest_s_ + shift_s_ - kWindow);
  };
  while (!settled()) {
    if (take_next()) continue;
    if (!finished_ || (ordered_.empty() && late_.empty())) return false;
    break;
  }
  if (late_is_first()) {
    out = late_.begin()->second;
    late_.erase(late_.begin());
  } else {
    out = ordered_.front();
    ordered_.pop();
  }
  out.time_s = given_s_ = std::max(out.time_s, given_s_);  // a part joined to another may begin a rounding earlier
  return true;
}

bool FrameClock::take_next() {
  if (ahead_.empty() || (!finished_ && ahead_.size() < kAhead)) return false;
  const RecordedFrame frame = ahead_.front();
  ahead_.pop();
  const double time_s = frame.time_s;
  if (!(time_s > kEarliest && time_s < kLatest)) {
    defects_.add("stamp that is no time", frame.line, 0.0);
  } else if (parts_.empty()) {
    if (stands_alone(time_s)) {
      defects_.add("time far from the frames around it", frame.line, 0.0);
    } else {
      begin_part(frame, ClockPart::Begin::kFirst);
    }
  } else if (time_s < newest_s_) {
    take_back(frame);
  } else if (time_s > newest_s_ + kFar) {
    take_ahead(frame);
  } else {
    accept(frame);
  }
  return true;
}

/// Width of the counter that has just wrapped; 0 when none has.
double FrameClock::wrap_of(double time_s) const {
  const double back_s = newest_s_ - time_s;
  // A stamp beyond 16 bits of ms is of an adapter that writes wider ones.
  if (turn_s_ > 0.0 && widest_s_ < kSixteenBits) {
    const double turn_s = widest_s_ >= turn_s_ ? kSixteenBits : turn_s_;
    return back_s > 0.5 * turn_s ? turn_s : 0.0;
  }
  // The stamp before lies just below the width, the one after just above zero.
  const double near_s = std::max(0.5, 20.0 * usual_s_);
  for (const double width_s : kWidths) {
    if (time_s >= 0.0 && time_s < near_s && newest_s_ <= width_s && width_s - newest_s_ < near_s && back_s > near_s &&
        width_s > 4.0 * near_s) {
      return width_s;
    }
  }
  return 0.0;
}

/// After how many frames the stamps come back to the latest by a jump; 0 when they stay behind.
std::size_t FrameClock::returns_after(double back_s) const {
  double before_s = newest_s_ - back_s;
  for (std::size_t k = 0; k < ahead_.size(); ++k) {
    const double time_s = ahead_[k].time_s;
    if (!(time_s < kLatest)) continue;
    if (time_s >= newest_s_ && time_s < newest_s_ + kFar && time_s - before_s >= 0.5 * back_s) return k + 1;
    if (time_s >= newest_s_) return 0;  // caught up at the clock's own pace
    before_s = time_s;
  }
  return 0;
}

/// Whether the frames after one lie elsewhere, near each other.
bool FrameClock::stands_alone(double time_s) const {
  if (ahead_.size() < 2) return false;
  std::size_t near = 0, back = 0;
  const std::size_t witnesses = std::min(kWitnesses, ahead_.size());
  const double other_s = parts_.empty() ? ahead_[0].time_s : newest_s_;
  if (std::abs(time_s - other_s) <= kFar) return false;  // a first frame of a slow sender
  for (std::size_t k = 0; k < witnesses; ++k) {
    const double witness_s = ahead_[k].time_s;
    near += std::abs(witness_s - time_s) <= kFar ? 1U : 0U;
    back += witness_s >= other_s - kWindow && witness_s <= other_s + kFar ? 1U : 0U;
  }
  return near < witnesses && back > witnesses / 2 && back > near;
}

void FrameClock::take_back(const RecordedFrame& frame) {
  const double back_s = newest_s_ - frame.time_s;
  if (late_left_ > 0) {
    --late_left_;
  } else if (back_s > kJitter) {
    if (const double width_s = wrap_of(frame.time_s); width_s > 0.0) {
      defects_.add("stamp that wraps", frame.line, frame.time_s + shift_s_ + width_s, true);
      shift_s_ += width_s;
      newest_s_ = frame.time_s;
      widest_s_ = 0.0;
      return accept(frame);
    }
    const std::size_t returns = returns_after(back_s);
    const bool goes_on = ahead_.size() + 1 >= kWitnesses;  // a last frame or two make no part
    const bool as_before = back_s < 2.0 * latest_by_s_;    // a bus whose frames are always written late ends so
    if (returns == 0 && goes_on && !as_before) {
      const bool within = frame.time_s > parts_.back().recorded_begin_s - kFar;
      if (!heard_[frame.bus] && within && !bus_behind_) bus_behind_ = frame;
      const bool anew = frame.time_s < kNearZero && newest_s_ > kNearZero;
      return begin_part(frame, anew ? ClockPart::Begin::kAnew : ClockPart::Begin::kSet);
    }
    late_left_ = returns > 0 ? returns - 1 : 0;
  }
  if (back_s > kWindow) return defects_.add("time far behind the frames around it", frame.line, newest_s_ + shift_s_);
  defects_.add("out of order, sorted", frame.line, frame.time_s + shift_s_, true);
  latest_by_s_ = std::max(latest_by_s_, back_s);
  sort_in(frame);
}

void FrameClock::take_ahead(const RecordedFrame& frame) {
  if (stands_alone(frame.time_s)) {
    return defects_.add("time far ahead of the frames around it", frame.line, newest_s_ + shift_s_);
  }
  const bool set = frame.time_s - newest_s_ > kDay || (frame.time_s > kAbsolute && newest_s_ < kAbsolute);
  if (set) return begin_part(frame, ClockPart::Begin::kSet);
  accept(frame);
}

void FrameClock::begin_part(const RecordedFrame& frame, ClockPart::Begin begin) {
  const double given_s = newest_s_ + shift_s_;
  if (begin != ClockPart::Begin::kFirst) shift_s_ = given_s + usual_s_ - frame.time_s;
  parts_.push_back({begin, frame.line, 0, frame.time_s, frame.time_s, shift_s_});
  newest_s_ = frame.time_s;
  widest_s_ = frame.time_s;
  late_left_ = 0;
  accept(frame);
}

void FrameClock::accept(const RecordedFrame& frame) {
  VOLTLAP_DEMAND(!parts_.empty() && frame.time_s >= newest_s_);
  const double interval_s = frame.time_s - newest_s_;
  if (interval_s < kFar) usual_s_ = usual_s_ == 0.0 ? interval_s : usual_s_ + kSlow * (interval_s - usual_s_);
  newest_s_ = frame.time_s;
  widest_s_ = std::max(widest_s_, newest_s_);
  heard_[frame.bus] = true;
  ClockPart& part = parts_.back();
  ++part.frames;
  part.recorded_end_s = newest_s_;
  RecordedFrame& given = ordered_.push();
  given = frame;
  given.time_s += shift_s_;
}

void FrameClock::sort_in(const RecordedFrame& frame) {
  heard_[frame.bus] = true;
  ++parts_.back().frames;
  RecordedFrame given = frame;
  given.time_s += shift_s_;
  late_.emplace(given.time_s, given);
}

}  // namespace voltlap::plant
