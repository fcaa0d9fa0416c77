// SPDX-License-Identifier: Apache-2.0
// Recordings of a CAN bus, read frame by frame, plain, gzip or zstd: the text formats of can_line.hpp, and what
// foreign_format.hpp makes into one of them.
// Recordings of real cars have defects. None is repaired in silence: a frame that cannot be trusted is left out and
// counted by its kind, with the line of the first one; what is mended is counted as well. Frames used and frames left
// out are together the frames of the file.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/line_reader.hpp"
#include "io/logs/can/can_line.hpp"
#include "io/logs/can/frame_clock.hpp"

namespace voltlap::plant {

struct ForeignRecording;

struct CanReading {
  BrokenStream broken = BrokenStream::kRefuse;
  bool keep_remote = false;  ///< remote frames are given as well; else they are left out and counted
  /// For recordings without stamps: interval [s] between the frames of an identifier (bit 31: 29 bits).
  std::map<std::uint32_t, double> period_s{};
};

/// What a recording was found to be, complete when it is read to its end.
struct CanSummary {
  std::size_t lines = 0;
  std::size_t frames_in_file = 0;      ///< frames of all kinds, and lines that should have been one
  std::size_t frames = 0;              ///< used
  double begin_s = 0.0, end_s = 0.0;   ///< times of the first and the latest frame
  std::vector<std::string> buses;      ///< names of the interfaces or channels
  std::vector<CanDefect> defects;
  std::vector<ClockPart> parts;
  std::vector<std::string> notes;      ///< decisions in words: parts of the clock, what stands for missing stamps
  std::string broken;                  ///< why the file ends before its end; empty when it does not
};

class CanRecording {
 public:
  /// Finds the format from the first lines. Throws InputError when it is none that is known, and for a recording
  /// without stamps while no period is known.
  explicit CanRecording(const std::string& path, CanReading reading = {});

  /// The next good frame in time (see FrameClock); false at the end. Left out and counted: lines that are no frame,
  /// error and remote frames, identifiers beyond 29 bits, empty slots (identifier 0, all bytes 0), wrong stamps.
  /// Throws InputError with file and line when most of the first 1000 lines are no frames.
  bool next(RecordedFrame& out);

  CanRecording(const CanRecording&) = delete;  // the clock counts into this recording's defects
  CanRecording& operator=(const CanRecording&) = delete;

  [[nodiscard]] CanFormat format() const { return format_; }
  /// In words, such as "Vector BLF".
  [[nodiscard]] std::string format_name() const { return format_name_.empty() ? name_of(format_) : format_name_; }
  /// Names of the buses that have spoken so far, by RecordedFrame::bus.
  [[nodiscard]] const std::vector<std::string>& buses() const { return state_.buses; }
  [[nodiscard]] const CanSummary& summary() const { return summary_; }
  /// "file:line" of the line read last; of a format without lines, the number of the frame.
  [[nodiscard]] std::string place() const;

 private:
  struct Source {
    std::string path, file;           ///< as given; what is read
    const ForeignRecording* foreign;  ///< nullptr: read natively
  };
  static Source source_of(const std::string& path);
  CanRecording(const Source& source, const CanReading& reading);
  void take_foreign(const ForeignRecording& foreign);
  bool read();
  bool time_by_period(RecordedFrame& frame);
  void judge_lines() const;
  [[noreturn]] void refuse_bus_behind(const RecordedFrame& first) const;
  void end();

  std::string path_, format_name_;
  LineReader reader_;
  CanFormat format_;
  CanLineState state_;
  CanReading reading_;
  CanSummary summary_;
  CanDefects defects_;
  std::optional<FrameClock> clock_;
  bool untimed_ = false;  ///< the frames have no stamps
  double period_clock_s_ = 0.0;
  bool period_began_ = false;
  std::uint8_t period_bus_ = 0;  ///< whose frames are that clock
  std::size_t unreadable_ = 0;
  bool ended_ = false;
};

/// Whether one of the first lines of a file is a frame in a format that is known.
[[nodiscard]] bool is_can_recording(const std::string& path);

/// 0x123, or 0x00000123 for 29 bits.
[[nodiscard]] std::string identifier_text(std::uint32_t id);

}  // namespace voltlap::plant
