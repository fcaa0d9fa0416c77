// SPDX-License-Identifier: Apache-2.0
// Whichever inverters the car has: their frames become the same samples, and the same command becomes their frames.
#pragma once
#include "codec/seal.hpp"
#include "master/inverter/amk.hpp"
#include "master/inverter/pm100.hpp"

namespace voltlap::master {

/// The last commands to a PM100, or to one of four AMK inverters: an adapter or a socket may hand a node what it has
/// sent itself. Each is known once.
struct SentCommands {
  static constexpr std::size_t kKept = 4;
  struct Command {
    Frame frame{};
    bool expected = false;
  };
  Command last[kKept] = {};
  std::uint8_t counter = 0;  ///< of the next one
};

/// Protocol, constant and scale are set by the owner of the receiver, who has the configuration.
struct InverterLink {
  InverterProtocol protocol = InverterProtocol::kPhaseCurrent;
  std::int32_t motor_constant_unm_per_a = 0;
  Pm100Reading pm100{};
  SentCommands sent{};
  AmkScale amk_scale{};
  AmkReading amk{};
  SentCommands amk_sent[kWheels] = {};
};

[[nodiscard]] InverterLink inverter_link(const Config& config);

/// False for the frames of an inverter that this car does not have: they are not even judged.
[[nodiscard]] bool is_heard(const InverterLink& link, std::uint32_t id);
/// Before a frame is judged: a PM100's command, or an AMK's setpoints, that arrive here have another sender.
void note_foreign_command(const Frame& frame, Instant now, InverterLink& link);

/// What goes to the inverters in this step; the queue must have room.
void transmit_to_inverter(const Output& output, InverterLink& link, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::master
