// SPDX-License-Identifier: Apache-2.0
// Recordings of a CAN bus, read frame by frame, plain or gzipped:
//   candump -l      (1436509052.249713) vcan0 044#2A36
//   Vector ASC         0.002014 1  1FFFFFF0x       Rx   d 8 01 00 00 05 0C 00 00 63
//   raw hex         0000026Bx000005220108160000000000      milliseconds x identifier data, no length
//   SLCAN text      t6B380050000551178EE0071F              with a stamp of 16 bits in ms that wraps at 60000
// Recordings of real cars have defects. None is repaired in silence: a frame that cannot be trusted is left out and
// counted by its kind, with the line of the first one.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/line_reader.hpp"
#include "io/logs/can_line.hpp"

namespace voltlap::plant {

/// One kind of defect: how often, and where first.
struct CanDefect {
  std::string kind;  ///< such as "time goes back"
  std::size_t count = 0;
  std::size_t first_line = 0;
  double first_s = 0.0, last_s = 0.0;  ///< recording's time of the first and the last one
};

/// What a recording was found to be, complete when it is read to its end.
struct CanSummary {
  std::size_t frames = 0, lines = 0;
  double begin_s = 0.0, end_s = 0.0;  ///< times of the first and the latest frame
  std::vector<CanDefect> defects;
};

class CanRecording {
 public:
  /// Finds the format from the first lines. Throws InputError when it is none of the four.
  explicit CanRecording(const std::string& path);

  /// The next good frame; false at the end. Left out and counted: lines that are no frame, error and remote frames,
  /// CAN FD, identifiers beyond 29 bits, empty slots (identifier 0, all bytes 0), frames whose time lies before
  /// that of an earlier one, and single frames more than 10 s ahead of both neighbours. Throws InputError with file
  /// and line when most of the first 1000 lines are no frames.
  bool next(TimedFrame& out);

  [[nodiscard]] CanFormat format() const { return format_; }
  [[nodiscard]] const CanSummary& summary() const { return summary_; }
  /// "file:line" of the frame read last.
  [[nodiscard]] std::string place() const { return reader_.place(); }

 private:
  void count(const char* kind, std::size_t line, double time_s);
  void judge_lines() const;
  void absolute_time(TimedFrame& frame);
  bool read(TimedFrame& out);
  void give(const TimedFrame& frame);

  LineReader reader_;
  CanFormat format_;
  CanLineState state_;
  double turns_s_ = 0.0, last_s_ = 0.0;  ///< of the stamp that wraps
  std::size_t unreadable_ = 0;
  std::optional<TimedFrame> pending_;  ///< the frame that the next call gives, unless its time stands alone
  CanSummary summary_;
};

/// Whether one of the first lines of a file is a frame in a format that is known.
[[nodiscard]] bool is_can_recording(const std::string& path);

}  // namespace voltlap::plant
