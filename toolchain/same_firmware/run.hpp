// SPDX-License-Identifier: Apache-2.0
// A drawn run: a configuration, a car with its driver, a bus, and both nodes in both versions, from power-on.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "node_api.hpp"
#include "pair.hpp"

namespace same_firmware {

/// How often something was reached: the proof that the drawn inputs are no trivial ones.
struct Reached {
  std::uint64_t calls = 0, runs = 0;
  std::array<std::uint64_t, 6> drive_states{}, bms_states{};  ///< how often entered, by the codes of car.dbc
  std::array<std::uint64_t, 16> master_faults{}, bms_faults{};
  std::uint64_t torque_ticks = 0;
  std::uint64_t failures = 0;  ///< requirements that failed, in both versions
};

/// What one node was given in one tick.
struct Step {
  bool restart = false;  ///< power off and on before it
  std::uint32_t now_ms = 0;
  std::vector<WireFrame> rx;
};

struct Difference {
  Which which = Which::kBms;
  std::uint64_t seed = 0;
  std::uint32_t tick = 0;
  Settings settings;
  std::vector<Step> steps;  ///< of that node, from power-on to the difference
};

/// Run `seed`, until a version differs or `calls_max` calls are made.
[[nodiscard]] std::optional<Difference> run(const Versions& versions, std::uint64_t seed, std::uint64_t calls_max,
                                            Reached& reached);

}  // namespace same_firmware
