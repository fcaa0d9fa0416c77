// SPDX-License-Identifier: Apache-2.0
// A process as a member of the lockstep: READY until the run begins, then one step for each tick that it is its turn.
//
//   plant frames, Sync | BMS frames, DoneBms | master frames, DoneMaster | DoneLogger, DoneHil
// as in can_dbc/lockstep.dbc
//
// It sleeps on a socket that only the one frame reaches on which it is its turn. The bus keeps its order, so whatever
// was sent before that frame then waits on the second socket.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "can_dbc/lockstep.hpp"
#include "can_dbc/tables.hpp"
#include "port/host/socket_can.hpp"

namespace voltlap::port {

[[nodiscard]] const char* member_name(can::Member member);
[[nodiscard]] bool is_lockstep(std::uint32_t id);
/// DoneBms, DoneMaster, ... : one shape, one identifier a member.
[[nodiscard]] Frame done_frame(can::Member member, std::uint32_t tick, std::size_t frames_sent, bool in_place);
[[nodiscard]] Frame ready_frame(can::Member member);
/// The member whose Done this is, kNone for another frame; `done` is filled then.
[[nodiscard]] can::Member done_of(const Frame& frame, can::DoneBms& done);

enum class Wake {
  kStep,   ///< its turn: `tick` is set
  kAlive,  ///< the plant waits for somebody or something else
  kStop,   ///< the run is over
  kNone,   ///< nothing for 100 ms of wall time, or a signal
};

class LockstepMember {
 public:
  /// `listen_to`: what the node receives besides its turn.
  LockstepMember(const std::string& interface, can::Member member, std::vector<CanFilter> listen_to);

  void announce() { turn_.send(&ready_, 1); }
  [[nodiscard]] Wake wait();
  [[nodiscard]] bool started() const { return started_; }
  [[nodiscard]] std::uint32_t tick() const { return tick_; }
  [[nodiscard]] Instant now() const { return Instant::from_ms(tick_ * can::kTickMs); }

  /// Sends the node's frames of this tick and that it is done, in one call.
  void done(const TxQueue& frames);
  /// What the node listens to.
  [[nodiscard]] SocketCan& data() { return data_; }

 private:
  can::Member member_;
  Frame ready_;
  SocketCan turn_, data_;
  std::uint32_t tick_ = 0;
  bool started_ = false;
};

}  // namespace voltlap::port
