// SPDX-License-Identifier: Apache-2.0
#include "io/bus/socket_bus.hpp"

#include <algorithm>
#include <optional>

#include "can_dbc/tables.hpp"
#include "port/host/lockstep_member.hpp"

namespace voltlap::plant {
namespace {

/// Nothing for a frame that belongs to nobody on this bus, or that says it is the plant's and is not.
std::optional<Sender> sender_of(const port::Arrival& arrival) {
  if (arrival.own) return Sender::kPlant;
  switch (can::sender_of(arrival.frame.id)) {
    case can::Node::kBms: return Sender::kBms;
    case can::Node::kMaster: return Sender::kMaster;
    default: return std::nullopt;
  }
}

}  // namespace

SocketBus::SocketBus(const std::string& interface)
    : data_(interface, {.filters = {port::kEveryFrame}, .own_frames = true, .error_frames = true}) {}

FrameView SocketBus::hand_out(std::uint32_t tick) {
  commands_.clear();
  std::uint32_t in_tick = 0;
  for (const port::Arrival& arrival : arrivals_) {
    if (port::is_lockstep(arrival.frame.id)) continue;
    const auto sender = sender_of(arrival);
    if (!sender) {
      ++foreign_;
      continue;
    }
    ++frames_of_[static_cast<std::size_t>(*sender)];
    ++in_tick;
    for (FrameSink* sink : sinks_) sink->on_frame(tick, *sender, arrival.frame);
    if (*sender != Sender::kPlant) commands_.push_back(arrival.frame);
  }
  arrivals_.clear();
  frames_sent_ += in_tick;
  frames_in_tick_max_ = std::max(frames_in_tick_max_, in_tick);
  return {commands_.data(), commands_.size()};
}

BusStatistics SocketBus::statistics() const {
  const port::SocketCounters& counters = data_.counters();
  return {.interface = data_.interface(), .foreign_frames = foreign_, .dropped_frames = counters.dropped,
          .error_frames = counters.error_frames, .send_retries = counters.send_retries};
}

}  // namespace voltlap::plant
