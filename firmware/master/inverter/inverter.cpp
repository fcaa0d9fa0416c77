// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/inverter.hpp"

#include "base/require.hpp"
#include "codec/send.hpp"
#include "master/transmit.hpp"

namespace voltlap::master {
namespace {

// A second sender that repeats one of them byte for byte asks for nothing new, in a count that the inverter has had.
bool is_echo(const Frame& frame, SentCommands& sent) {
  for (SentCommands::Command& command : sent.last) {
    if (!command.expected || command.frame != frame) continue;
    command.expected = false;
    return true;
  }
  return false;
}

// A place for the next one.
template <class Encode>
void remember(SentCommands& sent, const Encode& encode_into) {
  SentCommands::Command& kept = sent.last[sent.counter % SentCommands::kKept];
  encode_into(kept.frame);
  kept.expected = true;
  sent.counter = (sent.counter + 1U) & 0xFU;
}

void transmit_to_pm100(const Output& output, InverterLink& link, codec::Sealer& sealer, TxQueue& tx) {
  const can::Pm100Command command = pm100_command(output, link.motor_constant_unm_per_a, link.sent.counter);
  codec::send(command, sealer, tx);
  remember(link.sent, [&](Frame& frame) { encode(command, frame); });
}

void transmit_to_amk(const Output& output, InverterLink& link, TxQueue& tx) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    Frame frame;
    codec::encode_amk(amk_setpoints(output, k, link.amk_scale), k, frame);
    const bool room = tx.push(frame);
    VOLTLAP_REQUIRE(room);
    remember(link.amk_sent[k], [&](Frame& kept) { kept = frame; });
  }
}

void note_foreign_setpoints(const Frame& frame, Instant now, InverterLink& link) {
  const std::size_t wheel = codec::amk_wheel<codec::AmkSetpoints>(frame.id);
  if (wheel == kWheels || is_echo(frame, link.amk_sent[wheel])) return;
  link.amk.foreign = true;
  link.amk.foreign_at = now;
}

}  // namespace

InverterLink inverter_link(const Config& config) {
  InverterLink link;
  link.protocol = config.inverter_protocol;
  link.motor_constant_unm_per_a = config.motor_constant_unm_per_a;
  link.amk_scale = {config.motor_constant_unm_per_a, config.nominal_torque_mnm, config.motor_speed_max};
  return link;
}

bool is_heard(const InverterLink& link, std::uint32_t id) {
  const bool ours = id == can::InverterStatus::kId || id == can::MotorTemperatures::kId;
  if (ours) return link.protocol == InverterProtocol::kPhaseCurrent;
  if (is_pm100(id)) return link.protocol == InverterProtocol::kPm100;
  if (codec::amk_wheel<codec::AmkSetpoints>(id) != kWheels) return false;
  return !codec::is_amk(id) || link.protocol == InverterProtocol::kAmk;
}

void note_foreign_command(const Frame& frame, Instant now, InverterLink& link) {
  if (link.protocol == InverterProtocol::kAmk) return note_foreign_setpoints(frame, now, link);
  if (link.protocol != InverterProtocol::kPm100 || frame.id != can::Pm100Command::kId) return;
  if (is_echo(frame, link.sent)) return;
  link.pm100.foreign = true;
  link.pm100.foreign_at = now;
}

void transmit_to_inverter(const Output& output, InverterLink& link, codec::Sealer& sealer, TxQueue& tx) {
  switch (link.protocol) {
    case InverterProtocol::kPhaseCurrent: return transmit_command(output, sealer, tx);
    case InverterProtocol::kPm100: return transmit_to_pm100(output, link, sealer, tx);
    case InverterProtocol::kAmk: return transmit_to_amk(output, link, tx);
  }
}

}  // namespace voltlap::master
