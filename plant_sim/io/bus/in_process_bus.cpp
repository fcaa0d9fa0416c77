// SPDX-License-Identifier: Apache-2.0
#include "io/bus/in_process_bus.hpp"

#include <algorithm>
#include <stdexcept>

namespace voltlap::plant {

void InProcessBus::begin_tick(std::uint32_t tick) {
  tick_ = tick;
  frames_in_tick_ = 0;
}

void InProcessBus::send(Sender sender, const Frame& frame) {
  for (std::size_t node = 0; node < kSenders; ++node) {
    if (node == static_cast<std::size_t>(sender)) continue;
    Inbox& inbox = inbox_[node];
    if (inbox.taken) {
      inbox.count = 0;
      inbox.taken = false;
    }
    if (inbox.count == Inbox::kCapacity) throw std::length_error("in-process bus: a node does not receive its frames");
    inbox.frames[inbox.count++] = frame;
  }
  for (FrameSink* sink : sinks_) sink->on_frame(tick_, sender, frame);
  ++frames_sent_;
  frames_in_tick_max_ = std::max(frames_in_tick_max_, ++frames_in_tick_);
}

void InProcessBus::send(Sender sender, const TxQueue& frames) {
  for (const Frame& frame : frames) send(sender, frame);
}

FrameView InProcessBus::receive(Sender node) {
  Inbox& inbox = inbox_[static_cast<std::size_t>(node)];
  if (inbox.taken) inbox.count = 0;
  inbox.taken = true;
  return {inbox.frames.data(), inbox.count};
}

}  // namespace voltlap::plant
