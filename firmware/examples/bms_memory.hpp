// SPDX-License-Identifier: Apache-2.0
// What a BMS keeps over the loss of its supply, joined to the memory of a board: trips at once, charge now and then.
#pragma once
#include "app/bms_node.hpp"
#include "app/soc_keeper.hpp"
#include "app/trip_keeper.hpp"
#include "port/nvm.hpp"

namespace voltlap::examples {

class BmsMemory {
 public:
  explicit BmsMemory(port::Nvm& nvm) : nvm_(nvm) {}

  /// Before the first tick.
  void restore(app::BmsNode& node);
  /// After every tick.
  void keep(const app::BmsNode& node);

 private:
  void keep_trips(const app::BmsNode& node);
  void keep_soc(const app::BmsNode& node);

  port::Nvm& nvm_;
  app::TripKeeper trips_;
  app::SocKeeper soc_;
  bms::TripSlot trip_bytes_{};
  std::size_t trip_slot_ = 0;
  bool trip_waits_ = false;  ///< it has not been taken yet: again in the next tick
  bms::SocSlot soc_bytes_[bms::kSocSlots] = {};  ///< both for reading, the first for writing: too long for a stack
};

}  // namespace voltlap::examples
