// SPDX-License-Identifier: Apache-2.0
#include "io/bus/quiet_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "can_dbc/lockstep.hpp"
#include "can_dbc/tables.hpp"
#include "port/host/bus_error.hpp"
#include "port/host/lockstep_member.hpp"

namespace voltlap::plant {
namespace {

constexpr std::chrono::milliseconds kListen{200};  // twenty ticks of a bus that lives

bool belongs_to_a_run(const Frame& frame) {
  can::Sync sync;
  can::Alive alive;
  can::DoneBms done;
  if (decode(frame, sync)) return !sync.stop;
  if (decode(frame, alive)) return !alive.stop;
  return !port::is_lockstep(frame.id) || port::done_of(frame, done) != can::Member::kNone;
}

bool is_a_plants(const Frame& frame) { return can::sender_of(frame.id) == can::Node::kPlant; }

}  // namespace

void require_quiet_bus(port::SocketCan& socket, Pacing pacing, std::vector<port::Arrival>& arrivals) {
  std::this_thread::sleep_for(kListen);
  socket.drain(arrivals);
  const auto found = std::find_if(arrivals.begin(), arrivals.end(), [&](const port::Arrival& a) {
    return pacing == Pacing::kLockstep ? belongs_to_a_run(a.frame) : is_a_plants(a.frame);
  });
  if (found == arrivals.end()) return;
  throw port::BusSetupError(fmt::format(
      "CAN interface \"{0}\": found frame {1:03X} before the start: somebody already drives there; expected a "
      "quiet bus. "
      "End the other plant or the nodes of an earlier run (candump {0} shows them), or use another interface.",
      socket.interface(), found->frame.id));
}

}  // namespace voltlap::plant
