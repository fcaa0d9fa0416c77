// SPDX-License-Identifier: Apache-2.0
// Keeps what the BMS knows of its cells over the loss of the supply, as trip_keeper.hpp keeps its trips: the port reads
// two slots of its memory before the first tick, and writes one when it is told to.
#pragma once
#include <cstddef>

#include "app/bms_node.hpp"
#include "bms/estimate/soc_record.hpp"

namespace voltlap::app {

class SocKeeper {
 public:
  /// Before the node's first tick. Blank or damaged memory is none: the node starts from the open-circuit voltage.
  void restore(const bms::SocSlot (&slots)[bms::kSocSlots], BmsNode& node);

  /// After a tick: true when `slot` of the memory must become `bytes`: after every half point of charge, some
  /// 150 times in an endurance.
  [[nodiscard]] bool due(const BmsNode& node, std::size_t& slot, bms::SocSlot& bytes);

 private:
  bms::SocRecord kept_{};
  std::size_t next_slot_ = 0;
  Soc kept_soc_{};
};

}  // namespace voltlap::app
