// SPDX-License-Identifier: Apache-2.0
// What a board in lockstep has beside the seams: a plant that may hand it the configuration.
#pragma once
#include "port/board.hpp"
#include "port/image_info.hpp"
#include "port/lockstep/lockstep_port.hpp"
#include "port/lockstep/simulated_board.hpp"

namespace voltlap::port {

struct LockstepBoard {
  Board board;
  LockstepPort& plant;
};

/// As start_board(), which greets the plant as an image with a configuration of its own; here that is left to the
/// image. Each board in lockstep defines this one.
[[nodiscard]] LockstepBoard start_lockstep_board();

/// All of a board in lockstep around the rig that reaches its plant. Once.
inline LockstepBoard board_around(Rig& rig, RamNvm::Memory& memory) {
  static LockstepPort plant(rig, kImageInfo);
  static NoPins pins;
  static RamNvm nvm(memory);
  static SimulatedWatchdog watchdog(plant, rig);
  return {{plant, plant, pins, nvm, watchdog}, plant};
}

}  // namespace voltlap::port
