// SPDX-License-Identifier: Apache-2.0
#include "io/bus/stream_bus.hpp"

#include "can_dbc/tables.hpp"

namespace voltlap::plant {

const Interventions& StreamBus::begin_tick(std::uint32_t tick) {
  tick_ = tick;
  bus_.begin_tick(tick);
  return none_;
}

/// The board hands what its nodes send to each other; nodes in this process are called in their turn.
FrameView StreamBus::exchange(const TxQueue& plant) {
  bus_.send(Sender::kPlant, plant);
  const auto [has_bms, has_master] = board_.nodes();
  if (!has_bms) step_inside(Sender::kBms);
  const FrameView to_bms = has_bms ? bus_.receive(Sender::kBms) : FrameView{};
  if (has_bms && has_master) {
    step_board({plant.begin(), plant.size()});
  } else {
    step_board(has_bms ? to_bms : bus_.receive(Sender::kMaster));
  }
  if (!has_master) {
    step_inside(Sender::kMaster);
  } else {
    static_cast<void>(bus_.receive(Sender::kMaster));
  }
  return bus_.receive(Sender::kPlant);
}

void StreamBus::step_inside(Sender node) {
  const Instant now = Instant::from_ms(tick_ * can::kTickMs);
  tx_.clear();
  if (node == Sender::kBms) {
    inside_.bms(now, bus_.receive(node), tx_);
  } else {
    inside_.master(now, bus_.receive(node), tx_);
  }
  bus_.send(node, tx_);
}

void StreamBus::step_board(FrameView frames) {
  board_.step(tick_, frames, [this](Sender sender, const Frame& frame) { bus_.send(sender, frame); });
}

}  // namespace voltlap::plant
