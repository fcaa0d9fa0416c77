// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/inverter.hpp"

#include "codec/send.hpp"
#include "master/transmit.hpp"

namespace voltlap::master {
namespace {

bool same(const Frame& a, const Frame& b) {
  if (a.id != b.id || a.dlc != b.dlc) return false;
  for (std::size_t i = 0; i < Frame::kMaxBytes; ++i) {
    if (a.data[i] != b.data[i]) return false;
  }
  return true;
}

// A second sender that repeats one of them byte for byte asks for nothing new, in a count that the inverter has had.
bool is_echo(const Frame& frame, SentCommands& sent) {
  for (std::size_t i = 0; i < SentCommands::kKept; ++i) {
    if (!sent.expected[i] || !same(frame, sent.frame[i])) continue;
    sent.expected[i] = false;
    return true;
  }
  return false;
}

}  // namespace

bool is_heard(const InverterLink& link, std::uint32_t id) {
  if (link.protocol == InverterProtocol::kPm100) {
    return id != can::InverterStatus::kId && id != can::MotorTemperatures::kId && id != can::Pm100Command::kId;
  }
  return !is_pm100(id);
}

void note_foreign_command(const Frame& frame, Instant now, InverterLink& link) {
  if (link.protocol != InverterProtocol::kPm100 || frame.id != can::Pm100Command::kId) return;
  if (is_echo(frame, link.sent)) return;
  link.pm100.foreign = true;
  link.pm100.foreign_at = now;
}

void transmit_to_inverter(const Output& output, InverterLink& link, codec::Sealer& sealer, TxQueue& tx) {
  if (link.protocol == InverterProtocol::kPhaseCurrent) return transmit_command(output, sealer, tx);
  SentCommands& sent = link.sent;
  const can::Pm100Command command = pm100_command(output, link.motor_constant_unm_per_a, sent.counter);
  codec::send(command, sealer, tx);
  const std::size_t place = sent.counter % SentCommands::kKept;
  encode(command, sent.frame[place]);
  sent.expected[place] = true;
  sent.counter = (sent.counter + 1U) & 0xFU;
}

}  // namespace voltlap::master
