// SPDX-License-Identifier: Apache-2.0
// The time of recorded frames, made to run forward. Recorders of several buses write frames out of order, clocks are
// set while they record or start anew, counters wrap, single stamps are wrong. The rules, in this order:
//   no time      a stamp that is no finite time of this world is left out
//   wrap         a step back by the width of a counter (16 bits of ms, 32 bits of us, a day, ...) goes on
//   order        a frame up to kWindow behind the latest, after which the stamps come back to it, is sorted in
//   far behind   the same, but further behind: left out
//   far ahead    a frame more than kFar ahead after which the stamps come back: left out
//   set          the stamps step back, or ahead by more than a day, and stay there: the clock was set. The parts are
//                joined, one usual interval between them
//   anew         the same, but the new stamps begin near zero: the recorder started again. Joined likewise, and what
//                lay between is not known
// Nothing is dropped uncounted, and no stamp decides how much memory or time it takes.
#pragma once
#include <bitset>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

/// One kind of defect: how often, and where first.
struct CanDefect {
  std::string kind;  ///< such as "time far ahead of the frames around it"
  std::size_t count = 0;
  std::size_t first_line = 0;
  double first_s = 0.0, last_s = 0.0;  ///< recording's time of the first and the last one
  bool used = false;                   ///< the frames are used all the same, mended
};

/// Counts by kind.
class CanDefects {
 public:
  void add(const char* kind, std::size_t line, double time_s, bool used = false);
  [[nodiscard]] const std::vector<CanDefect>& all() const { return defects_; }

 private:
  std::vector<CanDefect> defects_;
};

/// A stretch of a recording over which its clock ran on.
struct ClockPart {
  enum class Begin { kFirst, kSet, kAnew };
  Begin begin = Begin::kFirst;
  std::size_t first_line = 0, frames = 0;
  double recorded_begin_s = 0.0, recorded_end_s = 0.0;  ///< as stamped
  double shift_s = 0.0;  ///< time given = stamp + shift
};

/// In words, where there is more than one part; a part begins in a `line` or a row.
[[nodiscard]] std::vector<std::string> clock_notes(const std::vector<ClockPart>& parts, const char* line);

/// First in, first out; one piece of memory that is kept.
class FrameQueue {
 public:
  [[nodiscard]] bool empty() const { return begin_ == frames_.size(); }
  [[nodiscard]] std::size_t size() const { return frames_.size() - begin_; }
  [[nodiscard]] const RecordedFrame& front() const { return frames_[begin_]; }
  [[nodiscard]] const RecordedFrame& operator[](std::size_t k) const { return frames_[begin_ + k]; }
  RecordedFrame& push() { return frames_.emplace_back(); }
  void pop();

 private:
  std::vector<RecordedFrame> frames_;
  std::size_t begin_ = 0;
};

class FrameClock {
 public:
  static constexpr double kWindow = 5.0, kFar = 10.0;  ///< s

  /// `turn_s`: width of the stamp where the format has one [s]: a step back by half of it is a wrap; 0: none known.
  FrameClock(CanDefects& defects, double turn_s) : defects_(defects), turn_s_(turn_s) {}

  /// Where the next frame of the file is written; it counts with push().
  [[nodiscard]] RecordedFrame& slot() { return slot_; }
  void push();
  /// After the last one.
  void finish() { finished_ = true; }
  [[nodiscard]] bool finished() const { return finished_; }
  /// The next frame in time; false when more frames must be pushed first, and at the end.
  bool pop(RecordedFrame& out);

  [[nodiscard]] const std::vector<ClockPart>& parts() const { return parts_; }
  /// The first frame of a bus that was not heard before, where the stamps step back into what was recorded already: one
  /// bus stands behind the other in the file, and no clock was set.
  [[nodiscard]] const std::optional<RecordedFrame>& bus_behind() const { return bus_behind_; }

 private:
  bool take_next();
  [[nodiscard]] bool late_is_first() const;
  void take_back(const RecordedFrame& frame);
  void take_ahead(const RecordedFrame& frame);
  void begin_part(const RecordedFrame& frame, ClockPart::Begin begin);
  void accept(const RecordedFrame& frame);
  void sort_in(const RecordedFrame& frame);
  [[nodiscard]] double wrap_of(double time_s) const;
  [[nodiscard]] std::size_t returns_after(double back_s) const;
  [[nodiscard]] bool stands_alone(double time_s) const;

  CanDefects& defects_;
  double turn_s_;
  bool finished_ = false;
  RecordedFrame slot_;
  FrameQueue ahead_;    ///< pushed, not yet judged
  FrameQueue ordered_;  ///< judged, in order, not yet given
  std::multimap<double, RecordedFrame> late_;  ///< likewise, those that came out of order, by the time that is given
  std::vector<ClockPart> parts_;
  std::bitset<256> heard_;  ///< buses
  std::optional<RecordedFrame> bus_behind_;
  double newest_s_ = 0.0;  ///< latest stamp of this part
  double shift_s_ = 0.0;   ///< from stamps to given times
  double usual_s_ = 0.0;   ///< interval between frames
  double widest_s_ = 0.0;  ///< greatest stamp since the last wrap
  double given_s_ = -1e300;  ///< time of the frame given last
  double latest_by_s_ = 0.0;   ///< how late a frame has been sorted in
  std::size_t late_left_ = 0;  ///< frames that are known to come before the stamps return
};

}  // namespace voltlap::plant
