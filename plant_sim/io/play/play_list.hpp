// SPDX-License-Identifier: Apache-2.0
// The frames that are played, with the time of each after the first: read whole before the first is sent, so that no
// reading delays one. 24 bytes a frame and its data.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "io/logs/can/can_recording.hpp"
#include "io/play/frame_choice.hpp"

namespace voltlap::plant {

struct PlayFrame {
  std::int64_t at_ns = 0;  ///< after the first
  std::uint32_t id = 0;    ///< bit 31 set: 29 bits
  std::uint8_t length = 0;
  std::uint8_t flags = 0;  ///< of CAN FD, as RecordedFrame has them
  bool flexible = false, remote = false;
  const std::uint8_t* data = nullptr;  ///< `length` bytes; of a remote frame none
};

class PlayList {
 public:
  /// In the order of time.
  void add(const RecordedFrame& frame);

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] PlayFrame operator[](std::size_t k) const;
  [[nodiscard]] std::int64_t span_ns() const { return empty() ? 0 : entries_.back().at_ns; }
  /// From the beginning of one round to that of the next: a mean interval lies between last frame and first.
  [[nodiscard]] std::int64_t round_ns() const;
  [[nodiscard]] std::size_t flexible() const { return flexible_; }

 private:
  struct Entry {
    std::int64_t at_ns;
    std::size_t data;  ///< where its bytes begin
    std::uint32_t id;
    std::uint8_t length, flags;
    bool flexible, remote;
  };
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> data_;
  double first_s_ = 0.0;
  std::size_t flexible_ = 0;
};

struct ReadPlayList {
  PlayList frames;
  std::vector<IdRange> absent;  ///< asked for, and not there
};

/// Reads a recording to its end. `progress` is told the number of frames now and then. Throws InputError where nothing
/// is chosen, and where the chosen frames are of several buses.
[[nodiscard]] ReadPlayList read_play_list(CanRecording& recording, const std::string& path, const FrameChoice& choice,
                                          const std::function<void(std::size_t)>& progress);

}  // namespace voltlap::plant
