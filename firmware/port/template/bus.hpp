// SPDX-License-Identifier: Apache-2.0
// The board's CAN controller.
#pragma once
#include "port/can.hpp"

namespace voltlap::port {

class BoardBus final : public Can {
 public:
  /// Bit timing, filters for what the nodes of the image listen to, and onto the bus; bounded waits. False when the
  /// controller does not answer.
  [[nodiscard]] bool init(bool has_bms, bool has_master);
  std::size_t receive(Frame* frames, std::size_t capacity) override;
  bool send(const TxQueue& frames) override;
};

}  // namespace voltlap::port
