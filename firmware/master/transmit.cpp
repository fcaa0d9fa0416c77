// SPDX-License-Identifier: Apache-2.0
#include "master/transmit.hpp"

#include "base/require.hpp"
#include "codec/send.hpp"

namespace voltlap::master {
namespace {

can::InverterCommand inverter_frame(const Output& out) {
  can::InverterCommand m;
  m.phase_current_ma = out.phase_current.raw();
  m.phase_current_ok = true;
  m.enable = out.enable;
  return m;
}

can::MasterStatus status_frame(const Output& out) {
  can::MasterStatus m;
  m.drive_state = out.drive_state;
  m.ts_request = out.ts_request;
  m.reset_request = out.reset_request;
  m.rtd_sound = out.rtd_sound;
  m.faults = out.faults.bits;
  m.torque_reason = out.torque_reason;
  m.pedal_request_ppm = out.pedal_request.raw();
  m.pedal_request_ok = true;
  return m;
}

}  // namespace

void transmit_command(const Output& output, codec::Sealer& sealer, TxQueue& tx) {
  VOLTLAP_REQUIRE(output.enable || output.phase_current == Current{});
  codec::send(inverter_frame(output), sealer, tx);
}

void transmit_status(const Output& output, codec::Sealer& sealer, TxQueue& tx) {
  codec::send(status_frame(output), sealer, tx);
}

}  // namespace voltlap::master
