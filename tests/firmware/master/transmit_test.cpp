// SPDX-License-Identifier: Apache-2.0
#include "master/transmit.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(MasterTransmit) {
  codec::Sealer sealer{};
  TxQueue tx{};
};

TEST(MasterTransmit, CommandAndStatusAreSealedWithCountersThatAdvance) {
  for (unsigned i = 0; i < 300; ++i) {
    tx.clear();
    transmit_command(Output{}, sealer, tx);
    transmit_status(Output{}, sealer, tx);
    LONGS_EQUAL(2, static_cast<long>(tx.size()));
    LONGS_EQUAL(can::InverterCommand::kId, tx[0].id);
    LONGS_EQUAL(can::MasterStatus::kId, tx[1].id);
    for (const Frame& frame : tx) {
      CHECK(codec::sealed_ok(frame));
      LONGS_EQUAL(i & 0xFF, codec::counter_of(frame));
    }
  }
}

TEST(MasterTransmit, OutputComesBackFromTheFrames) {
  Output out;
  out.phase_current = Current::from_raw(-123'400);
  out.enable = true;
  out.drive_state = DriveState::kReadyToDrive;
  out.ts_request = out.rtd_sound = true;
  out.faults.set(MasterFault::kGateVeto);
  out.torque_reason = TorqueReason::kChargeLimit;
  out.pedal_request = Ratio::from_raw(123'400);
  transmit_command(out, sealer, tx);
  transmit_status(out, sealer, tx);

  can::InverterCommand command;
  can::MasterStatus status;
  CHECK(decode(tx[0], command));
  CHECK(decode(tx[1], status));
  LONGS_EQUAL(-123'400, command.phase_current_ma);
  CHECK(command.enable);
  CHECK(status.drive_state == DriveState::kReadyToDrive);
  CHECK(status.ts_request && status.rtd_sound && !status.reset_request);
  LONGS_EQUAL(1U << 13, status.faults);
  CHECK(status.torque_reason == TorqueReason::kChargeLimit);
  LONGS_EQUAL(123'400, status.pedal_request_ppm);
}
