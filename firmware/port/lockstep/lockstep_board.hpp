// SPDX-License-Identifier: Apache-2.0
// What a board in lockstep has beside the seams: a plant that may hand it the configuration.
#pragma once
#include "port/board.hpp"
#include "port/lockstep/lockstep_port.hpp"

namespace voltlap::port {

struct LockstepBoard {
  Board board;
  LockstepPort& plant;
};

/// As start_board(), which greets the plant as an image with a configuration of its own; here that is left to the
/// image. Each board in lockstep defines both.
[[nodiscard]] LockstepBoard start_lockstep_board();

}  // namespace voltlap::port
