// SPDX-License-Identifier: Apache-2.0
#include "apps/supplied_loop.hpp"

#include <cstring>

namespace voltlap::plant {

SuppliedLoop::SuppliedLoop(const bms::Config& bms, const master::Config& master)
    : bms_config_(bms), master_config_(master) {}

void SuppliedLoop::bms(Instant now, FrameView rx, TxQueue& tx) {
  if (!bms_supply_.on(now)) return;
  if (bms_supply_.fresh) start_bms();
  bms_->tick(now, rx, tx);
  keep();
}

void SuppliedLoop::start_bms() {
  bms_.emplace(bms_config_);
  trips_ = {};
  soc_ = {};
  trips_.restore(trip_memory_, *bms_);
  soc_.restore(soc_memory_, *bms_);
  bms_supply_.fresh = false;
}

void SuppliedLoop::keep() {
  std::size_t slot = 0;
  bms::TripSlot trip{};
  if (trips_.due(*bms_, slot, trip)) std::memcpy(&trip_memory_[slot], &trip, sizeof trip);
  bms::SocSlot soc{};
  if (soc_.due(*bms_, slot, soc)) std::memcpy(&soc_memory_[slot], &soc, sizeof soc);
}

void SuppliedLoop::master(Instant now, FrameView rx, TxQueue& tx) {
  if (!master_supply_.on(now)) return;
  if (master_supply_.fresh) master_.emplace(master_config_);
  master_supply_.fresh = false;
  master_->tick(now, rx, tx);
}

void SuppliedLoop::lose(Sender node) { (node == Sender::kBms ? bms_supply_ : master_supply_).dead = true; }

void SuppliedLoop::reset(Sender node, Instant now, Duration off) {
  (node == Sender::kBms ? bms_supply_ : master_supply_).fail(now, off);
}

}  // namespace voltlap::plant
