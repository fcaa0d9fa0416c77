// SPDX-License-Identifier: Apache-2.0
// What is held against four inverters, step by step: which of them drops out of a drive, is late, or stands.
#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"
#include "firmware/master/inverter/amk_bench.hpp"
#include "master/inverter/amk_watch.hpp"

using namespace voltlap;
using namespace voltlap::master;
using namespace voltlap::master::bench;

TEST_GROUP(AmkSequence) {
  Config config = amk_config();
  Input in{};
  AmkWatchState state{};
  DriveState mode = DriveState::kTsActive;

  /// The next step, in which all four are heard to be so.
  void heard(InverterState all) {
    in.now = in.now + Duration::from_ms(kStepMs);
    in.inverter_state = good(all, in.now);
    watch_amk(config, mode, in, state);
  }
  void not_heard() {
    in.now = in.now + Duration::from_ms(kStepMs);
    in.inverter_state.quality = Quality::kStale;
    watch_amk(config, mode, in, state);
  }
  /// What the setpoints of this step ask for.
  void asks(bool on, std::int32_t ma = 0) {
    Output out;
    out.enable = out.dc_on = on;
    for (Current& current : out.wheel.of) current = Current::from_raw(ma);
    note_asked(out, Duration::from_ms(kStepMs), state);
  }
  void drive() {
    heard(InverterState::kDisabled);
    mode = DriveState::kReadyToDrive;
    asks(true);
    heard(InverterState::kEnabled);
    asks(true);
    CHECK_FALSE(state.dropped);
  }
  /// Motor `wheel` stands at 1000 rpm for 0.3 s while the wheels of `moving` are ever faster.
  bool stands(std::size_t wheel, const bool (&moving)[kWheels]) {
    state = AmkWatchState{};
    for (Sample<Speed>& speed : in.wheel_speed) speed = good(Speed::from_raw(5'000), in.now);
    bool found = false;
    for (int k = 0; k < 30; ++k) {
      in.now = in.now + Duration::from_ms(kStepMs);
      for (std::size_t w = 0; w < kWheels; ++w) {
        if (moving[w]) in.wheel_speed[w].value = in.wheel_speed[w].value + Speed::from_raw(200);
        in.motors.speed[w] = good(MotorSpeed::from_raw(w == wheel ? 1'000 : 1'000 + k), in.now);
      }
      watch_amk(config, mode, in, state);
      found = found || state.disobeys;
    }
    return found;
  }
};

// MST-070
TEST(AmkSequence, OneThatWasAskedAndHadObeyedAndIsNowOffHasDroppedOut) {
  drive();
  heard(InverterState::kDisabled);
  CHECK(state.dropped);
}

// MST-070: its DC link, and its voice, whether it was asked or not.
TEST(AmkSequence, ADriveEndsWithTheDcLinkOfOneAndWithItsSilence) {
  for (const bool asked : {true, false}) {
    for (const bool silent : {true, false}) {
      state = AmkWatchState{};
      mode = DriveState::kTsActive;
      drive();
      asks(asked);
      if (silent) {
        not_heard();  // though the last that it said is that it is on
      } else {
        heard(InverterState::kOff);
      }
      CHECK(state.dropped);
    }
  }
}

// MST-050, MST-070: frames that are late for a moment do not end the drive.
TEST(AmkSequence, WhatIsNoLongerAskedMaySwitchOffAndOnAgain) {
  drive();
  asks(false);
  heard(InverterState::kEnabled);  // not yet off
  asks(true);
  heard(InverterState::kDisabled);  // by what was asked before
  CHECK_FALSE(state.dropped);
  for (int k = 0; k < 10; ++k) {
    asks(true);
    heard(InverterState::kDisabled);  // takes its time
    CHECK_FALSE(state.dropped);
  }
  asks(true);
  heard(InverterState::kEnabled);
  asks(true);
  heard(InverterState::kDisabled);
  CHECK(state.dropped);
}

// MST-070: the drive goes on, so what is lost in it is lost, though nobody is asked at the moment.
TEST(AmkSequence, ADriveIsADriveWhileNobodyIsAsked) {
  drive();
  for (int k = 0; k < 5; ++k) {
    asks(false);
    heard(InverterState::kDisabled);
    CHECK_FALSE(state.dropped);
  }
  asks(false);
  heard(InverterState::kOff);
  CHECK(state.dropped);
}

// MST-070: told until all have their DC link on and the drive is over.
TEST(AmkSequence, WhatHasDroppedOutIsToldUntilItIsBack) {
  drive();
  heard(InverterState::kDisabled);
  heard(InverterState::kEnabled);
  CHECK(state.dropped);  // the drive is not over
  mode = DriveState::kTsActive;
  heard(InverterState::kOff);
  CHECK(state.dropped);
  not_heard();
  CHECK(state.dropped);
  heard(InverterState::kDisabled);
  CHECK_FALSE(state.dropped);
}

// MST-068: before all have been on there is no drive to drop out of, and after it none either.
TEST(AmkSequence, OutsideADriveNobodyDropsOut) {
  for (const DriveState before : {DriveState::kLvOn, DriveState::kTsActive}) {
    mode = before;
    heard(InverterState::kOff);
    not_heard();
    CHECK_FALSE(state.dropped);
  }
  heard(InverterState::kDisabled);
  mode = DriveState::kReadyToDrive;
  asks(true);
  heard(InverterState::kDisabled);
  asks(true);
  heard(InverterState::kOff);
  CHECK_FALSE(state.dropped);
  CHECK(state.waits);

  state = AmkWatchState{};
  mode = DriveState::kTsActive;
  drive();
  mode = DriveState::kLvOn;
  asks(false);
  heard(InverterState::kDisabled);
  asks(false);
  heard(InverterState::kOff);
  CHECK_FALSE(state.dropped);
}

// MST-068: 500 ms in either state in which the contactors are closed, and never with them open.
TEST(AmkSequence, ADcLinkIsLateAfterHalfASecondWithTheContactorsClosed) {
  for (const DriveState with : {DriveState::kTsActive, DriveState::kReadyToDrive}) {
    state = AmkWatchState{};
    mode = with;
    for (int k = 0; k < 50; ++k) {
      heard(InverterState::kOff);
      CHECK(state.waits && !state.late);
    }
    heard(InverterState::kOff);
    CHECK(state.late);
    heard(InverterState::kDisabled);
    CHECK_FALSE(state.late || state.waits);
    for (int k = 0; k < 60; ++k) heard(InverterState::kDisabled);
    CHECK_FALSE(state.late);
  }
  for (const DriveState without : {DriveState::kLvOn, DriveState::kTsRequested, DriveState::kFault}) {
    state = AmkWatchState{};
    mode = without;
    for (int k = 0; k < 100; ++k) heard(InverterState::kOff);
    CHECK(state.waits && !state.late);
  }
}

// MST-072: the two wheels of its own axle, and both of them.
TEST(AmkSequence, AMotorIsHeldAgainstBothWheelsOfItsAxle) {
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    for (unsigned pattern = 0; pattern < 1U << kWheels; ++pattern) {
      bool moving[kWheels];
      for (std::size_t w = 0; w < kWheels; ++w) moving[w] = (pattern >> w & 1U) != 0;
      const bool axle = wheel == 0 || wheel == 1 ? moving[0] && moving[1] : moving[2] && moving[3];
      CHECK_EQUAL(axle, stands(wheel, moving));
    }
  }
}

// MST-041: each by its own command, and no longer than the current is there.
TEST(AmkSequence, ACurrentIsHeldAgainstWhatThatMotorWasAskedFor) {
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    state = AmkWatchState{};
    bool found = false;
    const auto step_with = [&](std::int32_t ma) {
      asks(true, 40'000);
      for (Sample<Current>& current : in.motors.current) current = good(Current{}, in.now);
      in.motors.current[wheel].value = Current::from_raw(ma);
      heard(InverterState::kEnabled);
      found = state.disobeys;
    };
    for (int k = 0; k < 60; ++k) step_with(55'000);
    CHECK_FALSE(found);
    for (int k = 0; k < 60; ++k) step_with(-55'001);
    CHECK(found);
    step_with(55'000);
    CHECK_FALSE(found);
  }
}
