// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/inverter.hpp"

#include "codec/send.hpp"
#include "master/transmit.hpp"

namespace voltlap::master {

bool is_heard(const InverterLink& link, std::uint32_t id) {
  if (link.protocol == InverterProtocol::kPm100) {
    return id != can::InverterStatus::kId && id != can::MotorTemperatures::kId && id != can::Pm100Command::kId;
  }
  return !is_pm100(id);
}

void note_foreign_command(const Frame& frame, Instant now, InverterLink& link) {
  if (link.protocol != InverterProtocol::kPm100 || frame.id != can::Pm100Command::kId) return;
  link.pm100.foreign = true;
  link.pm100.foreign_at = now;
}

void transmit_to_inverter(const Config& config, const Output& output, std::uint8_t& counter, codec::Sealer& sealer,
                          TxQueue& tx) {
  if (config.inverter_protocol == InverterProtocol::kPhaseCurrent) return transmit_command(output, sealer, tx);
  codec::send(pm100_command(output, config.motor_constant_unm_per_a, counter), sealer, tx);
  counter = (counter + 1U) & 0xFU;
}

}  // namespace voltlap::master
