// SPDX-License-Identifier: Apache-2.0
// Control units in this process: called in their turn on a bus of memory.
#pragma once
#include <vector>

#include "base/time.hpp"
#include "can_dbc/tables.hpp"
#include "io/bus/plant_bus.hpp"
#include "io/bus/in_process_bus.hpp"

namespace voltlap::plant {

/// The control units, wherever they come from: each is handed the frames it missed and answers with its own.
class Ecus {
 public:
  virtual ~Ecus() = default;
  virtual void bms(Instant now, FrameView rx, TxQueue& tx) = 0;
  virtual void master(Instant now, FrameView rx, TxQueue& tx) = 0;
};

class InProcessLoop final : public PlantBus {
 public:
  explicit InProcessLoop(Ecus& ecus) : ecus_(ecus) {}

  void attach(FrameSink& sink) override { bus_.attach(sink); }
  const Interventions& begin_tick(std::uint32_t tick) override {
    bus_.begin_tick(tick);
    now_ = Instant::from_ms(tick * can::kTickMs);
    return none_;
  }
  FrameView exchange(const TxQueue& plant) override {
    bus_.send(Sender::kPlant, plant);
    tx_.clear();
    ecus_.bms(now_, bus_.receive(Sender::kBms), tx_);
    bus_.send(Sender::kBms, tx_);
    tx_.clear();
    ecus_.master(now_, bus_.receive(Sender::kMaster), tx_);
    bus_.send(Sender::kMaster, tx_);
    return bus_.receive(Sender::kPlant);
  }
  [[nodiscard]] const std::vector<LostNode>& lost() const override { return lost_; }
  [[nodiscard]] StopAsked stop_asked() const override { return StopAsked::kNo; }
  [[nodiscard]] std::uint64_t frames_sent() const override { return bus_.frames_sent(); }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const override { return bus_.frames_in_tick_max(); }

 private:
  Ecus& ecus_;
  InProcessBus bus_;
  TxQueue tx_;
  Instant now_;
  const Interventions none_{};
  const std::vector<LostNode> lost_{};
};

}  // namespace voltlap::plant
