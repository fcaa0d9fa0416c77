// SPDX-License-Identifier: Apache-2.0
// Whichever inverter the car has: its frames become the same samples, and the same command becomes its frame.
#pragma once
#include "codec/seal.hpp"
#include "master/inverter/pm100.hpp"

namespace voltlap::master {

/// The last commands to a PM100: an adapter or a socket may hand a node what it has sent itself. Each is known once.
struct SentCommands {
  static constexpr std::size_t kKept = 4;
  Frame frame[kKept] = {};
  bool expected[kKept] = {};
  std::uint8_t counter = 0;  ///< of the next one
};

/// Protocol and constant are set by the owner of the receiver, who has the configuration.
struct InverterLink {
  InverterProtocol protocol = InverterProtocol::kPhaseCurrent;
  std::int32_t motor_constant_unm_per_a = 0;
  Pm100Reading pm100{};
  SentCommands sent{};
};

/// False for the frames of an inverter that this car does not have: they are not even judged.
[[nodiscard]] bool is_heard(const InverterLink& link, std::uint32_t id);
/// Before a frame is judged: a PM100's command that arrives here has another sender.
void note_foreign_command(const Frame& frame, Instant now, InverterLink& link);

/// What goes to the inverter in this step; the queue must have room.
void transmit_to_inverter(const Output& output, InverterLink& link, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::master
