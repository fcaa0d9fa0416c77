// SPDX-License-Identifier: Apache-2.0
// The seam to the cells, for a board that measures them itself. It fills the very messages that a cell monitor on the
// bus sends: app/cell_monitor.hpp seals them, and they reach the node by the same checks as frames off the wire.
#pragma once
#include <cstddef>
#include <cstdint>

#include "can_dbc/car.hpp"

namespace voltlap::port {

class Cells {
 public:
  /// Measures all cells and thermistors; called once a tick, spreads the work over ticks as it likes, and takes at most
  /// what the board's tick budget has for it.
  virtual void step() = 0;
  /// The newest reading of group `out.group`, with `_ok` false for every cell of which none is to be believed (no
  /// answer, damaged on the way, a wire off). False when there is none newer than the last that was taken: nothing is
  /// sent then, and the sample grows old as it would with a monitor that is silent.
  virtual bool take(can::CellVoltages& out) = 0;
  virtual bool take(can::Temperatures& out) = 0;
  /// Which cells to bleed: bit i of word w is cell 24 w + i, as BalancingCommand has them. Stops by itself when it is
  /// not called for BalancingCommand::kTimeoutMs.
  virtual void bleed(const std::uint32_t* words, std::size_t count) = 0;

 protected:
  ~Cells() = default;
};

}  // namespace voltlap::port
