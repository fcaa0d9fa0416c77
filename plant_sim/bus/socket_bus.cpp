// SPDX-License-Identifier: Apache-2.0
#include "bus/socket_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include "can_dbc/tables.hpp"
#include "port/host/bus_error.hpp"
#include "port/host/lockstep_member.hpp"

namespace voltlap::plant {
namespace {

constexpr std::chrono::milliseconds kListen{200};  // twenty ticks of a bus that lives

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

void SocketBus::refuse_company(bool (*disturbs)(const Frame& frame)) {
  std::this_thread::sleep_for(kListen);
  read();
  const auto found = std::find_if(arrivals_.begin(), arrivals_.end(), [&](const port::Arrival& a) { return disturbs(a.frame); });
  if (found != arrivals_.end()) {
    throw port::BusSetupError(fmt::format(
        "somebody already drives on \"{0}\": frame {1:03X} was seen before the start. End the other plant or the nodes of "
        "an earlier run (candump {0} shows them), or use another interface", data_.interface(), found->frame.id));
  }
  arrivals_.clear();
}

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

BusFacts SocketBus::facts() const {
  const port::SocketCounters& counters = data_.counters();
  return {.interface = data_.interface(), .foreign_frames = foreign_, .dropped_frames = counters.dropped,
          .error_frames = counters.error_frames, .send_retries = counters.send_retries};
}

}  // namespace voltlap::plant
