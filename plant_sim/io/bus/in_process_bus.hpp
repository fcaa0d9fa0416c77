// SPDX-License-Identifier: Apache-2.0
// The CAN bus inside one process: every frame reaches every other node, in the order of sending, and every sink.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "io/bus/frame_sink.hpp"

namespace voltlap::plant {

/// One tick is: plant sends, BMS receives and sends, master receives and sends, plant receives. A node's inbox
/// holds what the others sent since it last received. Nothing is allocated after the sinks are attached.
class InProcessBus {
 public:
  void attach(FrameSink& sink) { sinks_.push_back(&sink); }

  void begin_tick(std::uint32_t tick);
  /// Throws std::length_error when a receiver let more than two ticks of frames pile up.
  void send(Sender sender, const Frame& frame);
  void send(Sender sender, const TxQueue& frames);
  /// The frames for `node` since its last call; valid until the next `send`.
  [[nodiscard]] FrameView receive(Sender node);

  [[nodiscard]] std::uint64_t frames_sent() const { return frames_sent_; }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const { return frames_in_tick_max_; }

 private:
  struct Inbox {
    static constexpr std::size_t kCapacity = 2 * kSenders * TxQueue::kCapacity;
    std::array<Frame, kCapacity> frames;
    std::size_t count = 0;
    bool taken = false;  ///< the node has seen the content: the next frame starts a new list
  };

  std::array<Inbox, kSenders> inbox_;
  std::vector<FrameSink*> sinks_;
  std::uint32_t tick_ = 0;
  std::uint32_t frames_in_tick_ = 0;
  std::uint32_t frames_in_tick_max_ = 0;
  std::uint64_t frames_sent_ = 0;
};

}  // namespace voltlap::plant
