// SPDX-License-Identifier: Apache-2.0
// Both nodes together: start-up, driving, limits, and the way back.
#include "firmware/app/bench.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::app::test;

TEST_GROUP(ClosedLoop) {
  Loop loop;
  std::int32_t ms_to_zero() {
    return loop.until([this] { return loop.command.phase_current_ma == 0; }, 1'000);
  }
};

TEST(ClosedLoop, NothingIsClosedOrEnabledWithoutTheDriver) {
  for (int i = 0; i < 300; ++i) {
    loop.tick();
    CHECK_FALSE(loop.contactors.air_plus_close || loop.contactors.air_minus_close || loop.contactors.precharge_close);
    CHECK_FALSE(loop.command.enable);
  }
  CHECK(loop.in(can::DriveState::kLvOn));
  CHECK(loop.bms_status.state == can::BmsState::kIdle);
  LONGS_EQUAL(0, loop.bms_status.faults);
  LONGS_EQUAL(0, loop.master_status.faults);
}

// MST-012
TEST(ClosedLoop, StartsUpToReadyToDriveThroughPrecharge) {
  loop.run(1'000);
  loop.io.ts_on_button = true;
  loop.run(20);
  CHECK(loop.in(can::DriveState::kTsRequested));
  loop.io.ts_on_button = false;
  LONGS_EQUAL(0, loop.until([this] { return loop.contactors.precharge_close; }, 100));
  CHECK_FALSE(loop.contactors.air_plus_close);
  const std::int32_t took = loop.until([this] { return loop.in(can::DriveState::kTsActive); });
  expect_time("precharge to tractive system active", took, 50, 500);
  CHECK(loop.contactors.air_plus_close && loop.contactors.air_minus_close);
  CHECK_FALSE(loop.command.enable);

  loop.brake(20'000);
  loop.io.rtd_button = true;
  LONGS_EQUAL(0, loop.until([this] { return loop.in(can::DriveState::kReadyToDrive); }, 100));
  CHECK(loop.master_status.rtd_sound);
  CHECK(loop.command.enable);
  LONGS_EQUAL(0, loop.command.phase_current_ma);
}

TEST(ClosedLoop, PedalReachesTheInverterIn0To550Ampere) {
  loop.start_to_ready();
  for (const std::int32_t per_mille : {0, 100, 500, 999, 1000}) {
    loop.pedal(per_mille);
    loop.run(200);
    DOUBLES_EQUAL(550'000.0 * per_mille / 1000, loop.command.phase_current_ma, 550.0);
  }
}

// MST-030
TEST(ClosedLoop, MaximumOfTheBatteryCutsThePhaseCurrentByTheBalanceOfPower) {
  loop.start_to_full_pedal();
  loop.inverter.motor_speed_rpm = 4'000;
  loop.run(1'000);
  CHECK(loop.master_status.torque_reason == can::TorqueReason::kNone);
  LONGS_EQUAL(550'000, loop.command.phase_current_ma);
  loop.inverter.motor_speed_rpm = 5'500;  // 500 A x 93.6 V x 0.9 / 86.4 V
  loop.run(20);
  CHECK(loop.master_status.torque_reason == can::TorqueReason::kDischargeLimit);
  CHECK(loop.command.phase_current_ma < 487'500);  // as if it went on to gain speed
  loop.run(50);
  DOUBLES_EQUAL(487'500, loop.command.phase_current_ma, 200);
  loop.run(1'000);  // no losses: measured by then
  DOUBLES_EQUAL(541'600, loop.command.phase_current_ma, 600);
}

// MST-031
TEST(ClosedLoop, CellsBelowTheirLeastVoltageTakeTheTorqueAway) {
  loop.start_to_full_pedal();
  loop.inverter.motor_speed_rpm = 4'000;
  loop.run(1'000);
  loop.cell_100uv = 24'950;  // 5 mV below; the trip is at 2.4 V
  expect_time("cells below their least voltage to zero torque", ms_to_zero(), 30, 500);
  CHECK(loop.master_status.torque_reason == can::TorqueReason::kDischargeLimit);
  CHECK(loop.in(can::DriveState::kReadyToDrive));
}

TEST(ClosedLoop, EveryFrameOfTheFirmwareIsSealedAndInItsPlace) {
  std::size_t most = 0;
  loop.tamper = [](Frame& frame) { CHECK(codec::sealed_ok(frame)); };
  for (int i = 0; i < 300; ++i) {
    loop.tick();
    most = std::max(most, loop.frames_in_tick);
  }
  CHECK(most <= 22);
}

// MST-011
TEST(ClosedLoop, OpenShutdownCircuitStopsTorqueAndOpensContactors) {
  loop.start_to_full_pedal();
  loop.io.shutdown_closed = false;
  expect_time("shutdown circuit open to zero torque", ms_to_zero(), 0, 0);
  CHECK_FALSE(loop.contactors.air_plus_close || loop.contactors.air_minus_close);
}

// MST-010
TEST(ClosedLoop, TripOfTheBatteryIsLatchedAndResetAtTheVehicle) {
  loop.start_to_full_pedal();
  loop.cell_100uv = 23'900;
  const std::int32_t took = loop.until([this] { return loop.in(can::DriveState::kFault); }, 2'000);
  expect_time("undervoltage to fault of the master", took, 500, 560);
  LONGS_EQUAL(0, loop.command.phase_current_ma);
  loop.cell_100uv = 39'000;
  loop.pedal(0);
  loop.run(20'000);  // the DC link must have fallen
  CHECK(loop.in(can::DriveState::kFault));
  loop.io.reset_button = true;
  loop.run(500);
  loop.io.reset_button = false;
  loop.run(500);
  CHECK(loop.in(can::DriveState::kLvOn));
  CHECK(loop.bms_status.state == can::BmsState::kIdle);
}

// MST-005
TEST(ClosedLoop, BrakeAtFullPedalStopsTorqueInTheSameTick) {
  loop.start_to_full_pedal();
  loop.brake(20'000);
  expect_time("EV.4.7 brake at full pedal to zero torque", ms_to_zero(), 0, 0);
  loop.brake(0);
  loop.run(1'000);
  LONGS_EQUAL(0, loop.command.phase_current_ma);
}

// MST-003
TEST(ClosedLoop, DisagreeingAcceleratorsStopTorqueAfter100Ms) {
  loop.start_to_full_pedal();
  loop.pedals.apps2_100uv -= 2'100;  // 10.5 % apart
  expect_time("T.4.2.5 disagreement to zero torque", ms_to_zero(), 100, 100);
}

// MST-004
TEST(ClosedLoop, FailedBrakeSensorStopsTorqueAfter100Ms) {
  loop.start_to_full_pedal();
  loop.pedals.brake_front_ok = false;
  expect_time("T.4.3 failed brake sensor to zero torque", ms_to_zero(), 100, 100);
}

// MST-002
TEST(ClosedLoop, AcceleratorOutsideItsRangeStopsTorqueAtOnce) {
  loop.start_to_full_pedal();
  loop.pedals.apps1_100uv = 49'000;
  expect_time("T.4.2.10 sensor out of range to zero torque", ms_to_zero(), 0, 0);
}

// MST-032
TEST(ClosedLoop, ElectricalPowerStaysBelow80KilowattAtEverySpeed) {
  bms::Config strong = bms::test::pack_config();
  strong.discharge_current_max = Current::from_raw(950'000);
  strong.discharge_current_trip = Current::from_raw(999'000);
  master::Config lossless;
  lossless.drive_efficiency = Ratio::from_raw(1'000'000);
  Loop car{strong, lossless};
  car.cell_100uv = 41'500;
  car.start_to_full_pedal();
  std::int64_t most_mw = 0;
  for (std::int32_t rpm = 0; rpm <= 12'000; rpm += 250) {
    car.inverter.motor_speed_rpm = rpm;
    for (int i = 0; i < 20; ++i) {
      car.tick();
      most_mw = std::max(most_mw, std::int64_t{car.pack.pack_current_ma} * car.pack.pack_voltage_100uv / 10'000);
    }
  }
  CHECK(most_mw <= 80'000'000);
  CHECK(most_mw >= 78'000'000);
}
