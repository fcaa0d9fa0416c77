// SPDX-License-Identifier: Apache-2.0
// One run an interface: whoever is about to start one listens first.
#pragma once
#include <vector>

#include "port/host/socket_can.hpp"

namespace voltlap::plant {

enum class Pacing { kLockstep, kRealTime };

/// Listens for 0.2 s, adds what arrives to `arrivals`, and throws port::BusSetupError when it belongs to another run.
/// Nodes that wait for their plant are no run yet; by the wall clock control units may be awake before their plant.
void require_quiet_bus(port::SocketCan& socket, Pacing pacing, std::vector<port::Arrival>& arrivals);

}  // namespace voltlap::plant
