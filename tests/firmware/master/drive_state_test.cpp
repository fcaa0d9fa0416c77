// SPDX-License-Identifier: Apache-2.0
#include "master/drive_state.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(DriveState) {
  bench::Car car;
  void check_mode(DriveState expected) {
    LONGS_EQUAL(static_cast<int>(expected), static_cast<int>(car.out.drive_state));
  }
};

TEST(DriveState, FirstStepLeavesAllZeroMemoryForLowVoltage) {
  car.run();
  check_mode(DriveState::kLvOn);
  CHECK_FALSE(car.out.ts_request);
}

TEST(DriveState, AllZeroInputStaysInLowVoltage) {
  car.in = Input{};
  car.out = step(car.config, car.in, car.state);
  check_mode(DriveState::kLvOn);
  CHECK_FALSE(car.out.enable);
  CHECK(car.out.faults.has(MasterFault::kBmsLost));
  CHECK(car.out.faults.has(MasterFault::kVehicleIoLost));
  CHECK(car.out.faults.has(MasterFault::kInverterLost));
}

TEST(DriveState, ButtonLeadsToTheRequestAndTheBmsToActive) {
  car.run(2);
  car.in.switches.value.ts_on_button = true;
  car.run();
  check_mode(DriveState::kTsRequested);
  CHECK(car.out.ts_request);
  car.in.bms_state.value = BmsState::kPrecharge;
  car.run();
  check_mode(DriveState::kTsRequested);
  car.in.bms_state.value = BmsState::kTsActive;
  car.run();
  check_mode(DriveState::kTsActive);
  CHECK(car.out.ts_request);
}

TEST(DriveState, ButtonThatWasNeverSeenReleasedDoesNothing) {
  car.in.switches.value.ts_on_button = true;
  car.run(50);
  check_mode(DriveState::kLvOn);
}

TEST(DriveState, ButtonWithOpenShutdownCircuitOrBusyBmsDoesNothing) {
  car.in.switches.value.shutdown_closed = false;
  car.run(2);
  car.in.switches.value.ts_on_button = true;
  car.run();
  check_mode(DriveState::kLvOn);

  car.in.switches.value = Switches{true, false, false, false};
  car.in.bms_state.value = BmsState::kOpen;
  car.run(2);
  car.in.switches.value.ts_on_button = true;
  car.run();
  check_mode(DriveState::kLvOn);
}

TEST(DriveState, RequestThatIsNotAnsweredIsGivenUp) {
  car.run(2);
  car.in.switches.value.ts_on_button = true;
  car.run();
  car.run(car.config.ts_request_timeout.ms() / bench::kStepMs - 1);
  check_mode(DriveState::kTsRequested);
  car.run();
  check_mode(DriveState::kLvOn);
}

// MST-012
TEST(DriveState, ReadyToDriveAsksForBrakeAndThenButton) {
  car.drive_to_ts_active();
  car.in.switches.value.rtd_button = true;  // without the brake
  car.run(3);
  check_mode(DriveState::kTsActive);
  car.brake(20'000);  // the brake after the button
  car.run(3);
  check_mode(DriveState::kTsActive);
  car.in.switches.value.rtd_button = false;
  car.run();
  car.in.switches.value.rtd_button = true;
  car.run();
  check_mode(DriveState::kReadyToDrive);
}

// MST-012
TEST(DriveState, BrakeAtItsLevelIsNotPressedForReadyToDrive) {
  car.drive_to_ts_active();
  car.brake(car.config.brake_pressed_level.raw());
  car.in.switches.value.rtd_button = true;
  car.run();
  check_mode(DriveState::kTsActive);
}

// MST-012
TEST(DriveState, ReadyToDriveIsRefusedWithThePedalDownOrBeforeActive) {
  car.drive_to_ts_active();
  car.brake(20'000);
  car.pedal(60);
  car.in.switches.value.rtd_button = true;
  car.run();
  check_mode(DriveState::kTsActive);

  bench::Car early;
  early.brake(20'000);
  early.run(2);
  early.in.switches.value.rtd_button = true;
  early.run();
  CHECK(early.out.drive_state == DriveState::kLvOn);
}

// MST-013
TEST(DriveState, SoundPlaysForItsTimeOnce) {
  car.drive_to_ts_active();
  car.brake(20'000);
  car.in.switches.value.rtd_button = true;
  car.run();
  std::int32_t sound_ms = 0;
  while (car.out.rtd_sound && sound_ms < 5'000) {
    car.run();
    sound_ms += bench::kStepMs;
  }
  LONGS_EQUAL(2'000, sound_ms);
  car.run(100);
  CHECK_FALSE(car.out.rtd_sound);
  car.in.now = car.in.now + Duration::from_ms(2'147'483'647);  // 25 days: half of what the clock counts
  car.run();
  check_mode(DriveState::kReadyToDrive);
  CHECK_FALSE(car.out.rtd_sound);
}

// MST-013
TEST(DriveState, NoOtherStateSounds) {
  car.run();
  CHECK_FALSE(car.out.rtd_sound);
  car.run();
  car.in.switches.value.ts_on_button = true;
  car.run();
  CHECK_FALSE(car.out.rtd_sound);
  car.in.bms_state.value = BmsState::kTsActive;
  car.run();
  CHECK_FALSE(car.out.rtd_sound);
}

// MST-011
TEST(DriveState, OpenShutdownCircuitEndsReadyToDriveInTheSameStep) {
  car.drive_at_full_pedal();
  car.in.switches.value.shutdown_closed = false;
  car.run();
  check_mode(DriveState::kLvOn);
  CHECK_FALSE(car.out.ts_request);
  CHECK_FALSE(car.out.enable);
  LONGS_EQUAL(0, car.out.phase_current.raw());
}

// MST-011
TEST(DriveState, EveryLostPartnerEndsReadyToDriveInTheSameStep) {
  for (const int what : {0, 1, 2}) {
    bench::Car c;
    c.drive_at_full_pedal();
    CHECK(c.out.phase_current.raw() > 0);
    if (what == 0) c.in.bms_state.quality = Quality::kStale;
    if (what == 1) c.in.switches.quality = Quality::kStale;
    if (what == 2) c.in.bms_state.value = BmsState::kOpen;
    c.run();
    CHECK(c.out.drive_state == DriveState::kLvOn);
    LONGS_EQUAL(0, c.out.phase_current.raw());
  }
}

// MST-011
TEST(DriveState, EveryLostPartnerTakesBackTheRequestAndEndsActiveInTheSameStep) {
  for (const bool active : {false, true}) {
    for (const int what : {0, 1, 2, 3}) {
      if (!active && what == 3) continue;  // a BMS that is not active yet is what it waits for
      bench::Car c;
      c.run(2);
      c.in.switches.value.ts_on_button = true;
      c.run();
      if (active) c.in.bms_state.value = BmsState::kTsActive;
      c.run();
      CHECK(c.out.drive_state == (active ? DriveState::kTsActive : DriveState::kTsRequested));
      if (what == 0) c.in.switches.value.shutdown_closed = false;
      if (what == 1) c.in.switches.quality = Quality::kStale;
      if (what == 2) c.in.bms_state.quality = Quality::kStale;
      if (what == 3) c.in.bms_state.value = BmsState::kOpen;
      c.run();
      CHECK(c.out.drive_state == DriveState::kLvOn);
      CHECK_FALSE(c.out.ts_request);
    }
  }
}

// MST-012
TEST(DriveState, ReadyToDriveIsRefusedWithAPedalBoxThatCannotBeBelieved) {
  car.drive_to_ts_active();
  car.in.brake_front.quality = Quality::kInvalid;
  car.brake(20'000);
  car.run(20);
  CHECK(car.out.faults.has(MasterFault::kBrakeSensor));
  car.in.switches.value.rtd_button = true;
  car.run();
  check_mode(DriveState::kTsActive);
}

// MST-010: what is no longer heard is lost, and what it said last is no news.
TEST(DriveState, WhoIsLostIsToldAsLostNotAsFailed) {
  for (const bool bms : {true, false}) {
    bench::Car c;
    if (bms) c.in.bms_state = Sample<BmsState>{BmsState::kFault, Instant{}, Quality::kStale};
    if (!bms) c.in.inverter_state = Sample<InverterState>{InverterState::kFault, Instant{}, Quality::kStale};
    c.run(2);
    CHECK(c.out.drive_state == DriveState::kLvOn);
    CHECK(c.out.faults.has(bms ? MasterFault::kBmsLost : MasterFault::kInverterLost));
    CHECK_FALSE(c.out.faults.has(bms ? MasterFault::kBmsFault : MasterFault::kInverterFault));
  }
}

// MST-010
TEST(DriveState, FaultIsLatchedUntilResetWithTheCauseGone) {
  car.drive_at_full_pedal();
  car.in.bms_state.value = BmsState::kFault;
  car.run();
  check_mode(DriveState::kFault);
  LONGS_EQUAL(0, car.out.phase_current.raw());
  car.in.switches.value.reset_button = true;  // cause still there
  car.run(5);
  check_mode(DriveState::kFault);
  CHECK(car.out.reset_request);
  car.in.switches.value.reset_button = false;
  car.in.bms_state.value = BmsState::kIdle;
  car.run(100);
  check_mode(DriveState::kFault);
  car.in.switches.value.reset_button = true;
  car.run();
  check_mode(DriveState::kLvOn);
}

// MST-010
TEST(DriveState, StuckOrUnseenResetButtonResetsNothing) {
  car.in.switches.value.reset_button = true;  // from the first step
  car.in.inverter_state.value = InverterState::kFault;
  car.run();
  check_mode(DriveState::kFault);
  car.in.inverter_state.value = InverterState::kDisabled;
  car.run(50);
  check_mode(DriveState::kFault);
  CHECK_FALSE(car.out.reset_request);
}

// MST-010
TEST(DriveState, WrongConfigurationCannotBeReset) {
  car.config.power_max_mw = 90'000'000;
  car.run(2);
  check_mode(DriveState::kFault);
  CHECK(car.out.faults.has(MasterFault::kConfigInvalid));
  car.in.switches.value.reset_button = true;
  car.run(5);
  check_mode(DriveState::kFault);
}

TEST(DriveState, ResetIsPassedOnInLowVoltage) {
  car.run(2);
  car.in.switches.value.reset_button = true;
  car.run();
  check_mode(DriveState::kLvOn);
  CHECK(car.out.reset_request);
}

TEST(DriveState, ResetIsNotPassedOnWhileTheTractiveSystemIsWanted) {
  car.drive_to_ts_active();
  car.in.switches.value.reset_button = true;
  car.run();
  CHECK_FALSE(car.out.reset_request);
}
