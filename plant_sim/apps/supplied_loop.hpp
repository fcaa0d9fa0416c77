// SPDX-License-Identifier: Apache-2.0
// BMS and master controller in this process, with a supply of their own that can be lost: what the BMS keeps in its
// memory over that is what a port would keep.
#pragma once
#include <optional>

#include "app/soc_keeper.hpp"
#include "app/trip_keeper.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/supply.hpp"
#include "io/bus/harness_bus.hpp"

namespace voltlap::plant {

class SuppliedLoop final : public SuppliedEcus {
 public:
  SuppliedLoop(const bms::Config& bms, const master::Config& master);

  void bms(Instant now, FrameView rx, TxQueue& tx) override;
  void master(Instant now, FrameView rx, TxQueue& tx) override;
  void lose(Sender node) override;
  void reset(Sender node, Instant now, Duration off) override;

 private:
  void start_bms();
  void keep();

  bms::Config bms_config_;
  master::Config master_config_;
  std::optional<app::BmsNode> bms_;
  std::optional<app::MasterNode> master_;
  Supply bms_supply_, master_supply_;
  app::TripKeeper trips_;
  app::SocKeeper soc_;
  bms::TripSlot trip_memory_[bms::kTripSlots]{};
  bms::SocSlot soc_memory_[bms::kSocSlots]{};
};

}  // namespace voltlap::plant
