// SPDX-License-Identifier: Apache-2.0
#include "port/lockstep/lockstep_board.hpp"

namespace voltlap::port {

Board start_board() {
  const LockstepBoard lockstep = start_lockstep_board();
  lockstep.plant.greet(nullptr, 0, nullptr, 0, 0);
  return lockstep.board;
}

}  // namespace voltlap::port
