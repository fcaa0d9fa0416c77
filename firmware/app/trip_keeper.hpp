// SPDX-License-Identifier: Apache-2.0
// Keeps the BMS's latched trips over a power cycle. The port reads two slots of its memory before the first tick, and
// writes one when it is told to; what the memory is nobody here knows.
#pragma once
#include <cstddef>

#include "app/bms_node.hpp"
#include "bms/trip_record.hpp"

namespace voltlap::app {

class TripKeeper {
 public:
  /// Before the node's first tick. A memory that is damaged in both slots latches ConfigInvalid: nobody knows what was
  /// latched, and the reset button at the vehicle is asked for.
  void restore(const bms::TripSlot (&slots)[bms::kTripSlots], BmsNode& node);

  /// After a tick: true when `slot` of the memory must become `bytes`, before the supply may be lost.
  [[nodiscard]] bool due(const BmsNode& node, std::size_t& slot, bms::TripSlot& bytes);

 private:
  bms::TripRecord kept_{};
  std::size_t next_slot_ = 0;
};

}  // namespace voltlap::app
