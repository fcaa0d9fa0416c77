// SPDX-License-Identifier: Apache-2.0
#include "examples/bms_memory.hpp"

namespace voltlap::examples {

using port::NvmRecord;
using port::NvmResult;

void BmsMemory::restore(app::BmsNode& node) {
  static_cast<void>(nvm_.prepare());  // a memory that cannot be used reads as blank
  bms::TripSlot trips[bms::kTripSlots];
  for (std::size_t slot = 0; slot < bms::kTripSlots; ++slot) {
    nvm_.read(NvmRecord::kTrips, slot, trips[slot].bytes, sizeof trips[slot].bytes);
  }
  trips_.restore(trips, node);
  for (std::size_t slot = 0; slot < bms::kSocSlots; ++slot) {
    nvm_.read(NvmRecord::kSoc, slot, soc_bytes_[slot].bytes, sizeof soc_bytes_[slot].bytes);
  }
  soc_.restore(soc_bytes_, node);
}

void BmsMemory::keep(const app::BmsNode& node) {
  keep_trips(node);
  keep_soc(node);
  static_cast<void>(nvm_.step());
}

void BmsMemory::keep_trips(const app::BmsNode& node) {
  if (!trip_waits_) trip_waits_ = trips_.due(node, trip_slot_, trip_bytes_);
  if (!trip_waits_) return;
  // BMS-025. A memory that is busy or full takes it later; the node holds the trip all the same.
  trip_waits_ = nvm_.write(NvmRecord::kTrips, trip_slot_, trip_bytes_.bytes, sizeof trip_bytes_.bytes) !=
                NvmResult::kOk;
}

/// One that is not taken is left out: the next half point of charge brings another.
void BmsMemory::keep_soc(const app::BmsNode& node) {
  std::size_t slot = 0;
  bms::SocSlot& out = soc_bytes_[0];
  if (!soc_.due(node, slot, out)) return;
  static_cast<void>(nvm_.write(NvmRecord::kSoc, slot, out.bytes, sizeof out.bytes));
}

}  // namespace voltlap::examples
