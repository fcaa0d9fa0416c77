// SPDX-License-Identifier: Apache-2.0
#include "app/soc_keeper.hpp"

namespace voltlap::app {
namespace {

constexpr Soc kMoved = Soc::from_raw(5'000);  // half a point: a quarter of what a restart may move

}  // namespace

// BMS-083
void SocKeeper::restore(const bms::SocSlot (&slots)[bms::kSocSlots], BmsNode& node) {
  bms::read_slots(slots, kept_, next_slot_);
  node.restore_soc(kept_);
}

bool SocKeeper::due(const BmsNode& node, std::size_t& slot, bms::SocSlot& bytes) {
  const bms::SocEstimate& soc = node.state().soc;
  if (!soc.valid) return false;
  if (kept_.cells != 0 && magnitude(soc.value - kept_soc_) < kMoved) return false;
  bms::keep(node.config(), soc, kept_);
  kept_.pieces = node.state().energy_to_go.pieces;
  ++kept_.writing;
  kept_soc_ = soc.value;
  slot = next_slot_;
  next_slot_ = 1 - next_slot_;
  bms::to_slot(kept_, bytes);
  return true;
}

}  // namespace voltlap::app
