// SPDX-License-Identifier: Apache-2.0
// Frames of every kind onto a CAN interface: classic, extended, remote, CAN FD, as they were recorded.
#pragma once
#include <cstdint>
#include <string>

#include "io/play/player.hpp"
#include "port/host/can_interface.hpp"

namespace voltlap::plant {

class PlaySocket final : public PlaySink {
 public:
  /// `flexible`: frames of CAN FD are to be sent, how many. Throws port::BusSetupError, also where the interface takes
  /// none.
  PlaySocket(std::string interface, std::size_t flexible);

  /// A full queue is waited for, for a bounded time; throws port::BusDownError behind it.
  void send(const PlayFrame& frame) override;
  /// Waits for room in the queue.
  [[nodiscard]] std::uint64_t retries() const { return retries_; }

 private:
  std::string interface_;
  port::CanDescriptor descriptor_;
  std::uint64_t retries_ = 0;
};

}  // namespace voltlap::plant
