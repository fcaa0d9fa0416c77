// SPDX-License-Identifier: Apache-2.0
// What an emulated board counts of itself.
#pragma once
#include <cstdint>

namespace voltlap::plant {

/// Instructions of steps, from the frames read to the frames sent.
struct StepCosts {
  std::uint64_t steps = 0, instructions = 0;
  std::uint32_t worst = 0, worst_tick = 0;

  void add(std::uint32_t cost, std::uint32_t tick) {
    ++steps;
    instructions += cost;
    if (cost <= worst) return;
    worst = cost;
    worst_tick = tick;
  }
};

/// Zero where nobody counts.
struct BoardAccount {
  StepCosts bms{}, master{}, both{};             ///< both: of a tick
  std::uint32_t stack_used = 0, stack_size = 0;  ///< [byte], known after the end of the run
};

}  // namespace voltlap::plant
