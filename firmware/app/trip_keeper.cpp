// SPDX-License-Identifier: Apache-2.0
#include "app/trip_keeper.hpp"

#include "bms/faults.hpp"

namespace voltlap::app {

// BMS-025: a trip outlives the supply.
void TripKeeper::restore(const bms::TripSlot (&slots)[bms::kTripSlots], BmsNode& node) {
  const bms::TripHistory history = bms::read_slots(slots);
  kept_ = history.newest;
  next_slot_ = history.oldest_slot;
  node.restore_trips(history.damaged ? bms::bit_of(can::BmsFault::kConfigInvalid) : kept_.latched);
}

bool TripKeeper::due(const BmsNode& node, std::size_t& slot, bms::TripSlot& bytes) {
  const std::uint32_t latched = node.state().faults.latched;
  if (latched == kept_.latched) return false;
  kept_.latched = latched;
  ++kept_.writing;
  slot = next_slot_;
  next_slot_ = 1 - next_slot_;
  bytes = bms::to_slot(kept_);
  return true;
}

}  // namespace voltlap::app
