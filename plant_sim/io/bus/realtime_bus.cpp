// SPDX-License-Identifier: Apache-2.0
#include "io/bus/realtime_bus.hpp"

#include "core/demand.hpp"
#include "io/bus/quiet_bus.hpp"
#include "port/host/bus_error.hpp"

namespace voltlap::plant {
RealtimeBus::RealtimeBus(const std::string& interface) : SocketBus(interface) {
  require_quiet_bus(data_, Pacing::kRealTime, arrivals_);
  arrivals_.clear();
  pacer_ = port::Pacer(can::kTickMs * 1000, port::Lag::kCatchUp);
}

const Interventions& RealtimeBus::begin_tick(std::uint32_t tick) {
  VOLTLAP_DEMAND(tick >= tick_);
  pacer_.wait();
  tick_ = tick;
  return none_;
}

FrameView RealtimeBus::exchange(const TxQueue& plant) {
  try {
    data_.send(plant.begin(), plant.size());
    read();
  } catch (const port::BusDownError& error) {
    throw BusFailure(error.what());
  }
  const FrameView commands = hand_out(tick_);
  note_silence();
  return commands;
}

/// A control unit that was heard and falls silent is lost.
void RealtimeBus::note_silence() {
  for (const Sender sender : {Sender::kBms, Sender::kMaster}) {
    const auto i = static_cast<std::size_t>(sender);
    if (frames_of_[i] != frames_before_[i]) {
      frames_before_[i] = frames_of_[i];
      heard_[i] = tick_;
    } else if (!gone_[i] && frames_of_[i] > 0 && tick_ - heard_[i] > kSilence_ticks) {
      gone_[i] = true;
      lost_.push_back({sender == Sender::kBms ? "bms" : "master", true});
    }
  }
}

BusStatistics RealtimeBus::statistics() const {
  BusStatistics out = SocketBus::statistics();
  out.pacing = "realtime";
  out.late_steps = pacer_.late_steps();
  out.late_worst_s = static_cast<double>(pacer_.worst_us()) * 1e-6;
  return out;
}

}  // namespace voltlap::plant
