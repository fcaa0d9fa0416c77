// SPDX-License-Identifier: Apache-2.0
// Control units as a process on a CAN interface: in lockstep with a plant, or by the wall clock.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/lockstep.hpp"
#include "port/host/socket_can.hpp"

namespace voltlap::plant {

struct EcuNode {
  can::Member member = can::Member::kNone;
  std::vector<port::CanFilter> listens_to{};
  std::function<void(Instant now, FrameView rx, TxQueue& tx)> tick{};
};

/// Steps with the plant until the run is over and returns an exit code. A plant that falls silent for 2 s of wall
/// time leaves the nodes to themselves: they step by the clock for 5 s, which takes them to their safe state.
/// Nodes stand in the order of their turns. Throws port::BusSetupError and port::BusDownError.
int run_in_lockstep(const std::string& interface, std::vector<EcuNode> nodes);

/// Steps every 10 ms of wall time until interrupted, and reports late steps.
int run_in_real_time(const std::string& interface, std::vector<EcuNode> nodes);

}  // namespace voltlap::plant
