// SPDX-License-Identifier: Apache-2.0
// The seam between a node and the bus: frames in, frames out. Each place the firmware runs has its own behind it.
#pragma once
#include <cstddef>

#include "base/can_frame.hpp"

namespace voltlap::port {

class Can {
 public:
  /// Takes frames that have arrived, in their order, at most `capacity`; never waits. Returns how many.
  virtual std::size_t receive(Frame* frames, std::size_t capacity) = 0;
  /// Puts all frames on the bus, in their order; false when not all of them went out.
  virtual bool send(const TxQueue& frames) = 0;

 protected:
  ~Can() = default;
};

}  // namespace voltlap::port
