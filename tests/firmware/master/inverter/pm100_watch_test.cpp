// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100_watch.hpp"

#include <tuple>

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(Pm100Watch) {
  Input in{};
  Pm100WatchState state{};

  void setup() override {
    in.now = Instant::from_ms(1'000);
    set(in.motor_speed, MotorSpeed::from_raw(1'000));
    wheels(8'000);
    set(in.inverter_dc_current, Current::from_raw(100'000));
    set(in.pack_current, Current::from_raw(100'000));
  }
  template <class T>
  void set(Sample<T>& sample, T value) { sample = {value, in.now, Quality::kGood}; }
  void wheels(std::int32_t mmps) {
    for (Sample<Speed>& wheel : in.wheel_speed) set(wheel, Speed::from_raw(mmps));
  }
  bool step(bool ready = true) {
    in.now = in.now + Duration::from_ms(10);
    watch_pm100(ready, in, state);
    return state.implausible;
  }
  /// Steps until it is told, 0: not within a second.
  int steps_until_told() {
    for (int k = 1; k <= 100; ++k) {
      if (step()) return k;
    }
    return 0;
  }
};

// MST-066
TEST(Pm100Watch, AStandingSpeedIsTakenForFrozenWhenTheWheelsGoOn) {
  CHECK_FALSE(step());
  wheels(9'000);
  LONGS_EQUAL(0, steps_until_told());
  wheels(9'001);
  LONGS_EQUAL(11, steps_until_told());  // 100 ms behind the one that finds it
  state = {};
  wheels(8'000);
  step();
  wheels(6'999);
  LONGS_EQUAL(11, steps_until_told());
  in.motor_speed.value = MotorSpeed::from_raw(900);
  CHECK_FALSE(step());
}

// MST-066, MST-072, MST-075: one that says nothing once it is off does not keep a car that stands from a reset.
TEST(Pm100Watch, AMotorThatReadsNothingAgreesWithWheelsThatStand) {
  step();
  in.motor_speed.value = MotorSpeed{};  // at 8 m/s
  step();
  wheels(101);
  CHECK(steps_until_told() > 0);
  CHECK(step());
  wheels(100);
  CHECK_FALSE(step());
  wheels(1'100);
  LONGS_EQUAL(0, steps_until_told());
  wheels(1'101);  // and is found again
  CHECK(steps_until_told() > 0);
  for (const std::size_t turns : {std::size_t{2}, std::size_t{3}}) {
    wheels(0);
    in.wheel_speed[turns].value = Speed::from_raw(9'000);
    LONGS_EQUAL(0, steps_until_told());
    in.wheel_speed[5 - turns].value = Speed::from_raw(1'101);  // both turn, beside a motor that goes on reading nothing
    LONGS_EQUAL(11, steps_until_told());
    wheels(0);
    step();
  }
  wheels(8'000);
  in.motor_speed.value = MotorSpeed::from_raw(1);  // one that reads something while they stand is frozen
  step();
  wheels(0);
  CHECK(steps_until_told() > 0);
}

// MST-066: a wheel's own sensor that fails, and a reading that jumps, are no inverter's.
TEST(Pm100Watch, OneWheelAloneOrOneSampleAccusesNobody) {
  step();
  in.wheel_speed[2].value = Speed::from_raw(0);
  LONGS_EQUAL(0, steps_until_told());
  in.wheel_speed[3].value = Speed::from_raw(16'000);  // the other way
  LONGS_EQUAL(0, steps_until_told());
  wheels(8'000);
  for (int k = 0; k < 50; ++k) {
    wheels(k % 5 == 0 ? 12'000 : 8'000);
    CHECK_FALSE(step());
  }
}

// MST-066: a charger's current passes the inverter by.
TEST(Pm100Watch, CurrentsApartAreJudgedInADriveAlone) {
  in.inverter_dc_current.value = Current{};
  in.pack_current.value = Current::from_raw(-120'000);
  for (int k = 0; k < 300; ++k) CHECK_FALSE(step(false));
  for (int k = 0; k < 100; ++k) CHECK_FALSE(step());
  CHECK(step());
}

// MST-066
TEST(Pm100Watch, WheelsThatAreNotKnownAccuseNobody) {
  for (Quality* quality : {&in.wheel_speed[2].quality, &in.wheel_speed[3].quality, &in.motor_speed.quality}) {
    state = {};
    wheels(8'000);
    CHECK_FALSE(step());
    wheels(0);
    *quality = Quality::kStale;
    LONGS_EQUAL(0, steps_until_told());
    *quality = Quality::kGood;
    LONGS_EQUAL(0, steps_until_told());  // what was before the gap is no beginning
    wheels(8'000);
    LONGS_EQUAL(11, steps_until_told());
  }
}

// MST-066: a car that rolls when the controller starts has not changed its speed yet.
TEST(Pm100Watch, FirstReadingIsTheBeginning) {
  in.motor_speed.value = MotorSpeed{};
  LONGS_EQUAL(0, steps_until_told());
}

// MST-066: each by more than 1 m/s, and in the same sense.
TEST(Pm100Watch, BothWheelsMustHaveMoved) {
  for (const std::int32_t sense : {1, -1}) {
    for (const auto& [left, right, told] : {std::tuple{1'001, 1'000, false}, {1'000, 1'001, false}, {1'001, 0, false},
                                            {0, 1'001, false}, {1'001, 1'001, true}}) {
      state = {};
      wheels(8'000);
      step();
      in.wheel_speed[2].value = Speed::from_raw(8'000 + sense * left);
      in.wheel_speed[3].value = Speed::from_raw(8'000 + sense * right);
      CHECK_EQUAL(told, steps_until_told() > 0);
    }
  }
}

// MST-066
TEST(Pm100Watch, CurrentThatIsNotKnownAccusesNobody) {
  in.inverter_dc_current.value = Current{};
  for (Quality* quality : {&in.inverter_dc_current.quality, &in.pack_current.quality}) {
    *quality = Quality::kStale;
    for (int k = 0; k < 300; ++k) CHECK_FALSE(step());
    *quality = Quality::kGood;
  }
}

// MST-066: 60 A apart of 100 A are allowed.
TEST(Pm100Watch, DcCurrentAstrayOfThePacksIsToldAfterASecond) {
  in.inverter_dc_current.value = Current::from_raw(40'000);
  for (int k = 0; k < 300; ++k) CHECK_FALSE(step());
  in.inverter_dc_current.value = Current::from_raw(39'999);
  for (int k = 0; k < 100; ++k) CHECK_FALSE(step());
  CHECK(step());
}

TEST_GROUP(InverterDrop) {
  Input in{};
  InverterDropState state{};
  void is(InverterState s, bool good = true, bool ready = true) {
    in.inverter_state = {s, in.now, good ? Quality::kGood : Quality::kStale};
    watch_dropping(ready, in, state);
  }
};

// MST-065
TEST(InverterDrop, LockoutTimeOutAndSilenceAfterEnablingEndTheDrive) {
  const struct { InverterState state; bool good; } cases[] = {
      {InverterState::kOff, true}, {InverterState::kCommandTimeout, true}, {InverterState::kEnabled, false}};
  for (const auto& c : cases) {
    state = {};
    is(InverterState::kOff);
    CHECK_FALSE(state.dropped);  // not enabled yet: it is waiting for the first command
    is(InverterState::kDisabled);
    is(InverterState::kEnabled);
    CHECK_FALSE(state.dropped);
    is(c.state, c.good);
    CHECK(state.dropped);
    is(InverterState::kDisabled);
    CHECK_FALSE(state.dropped);
  }
}

// MST-065
TEST(InverterDrop, AnInverterThatStaysEnabledHasNotDroppedOut) {
  for (int k = 0; k < 10; ++k) {
    is(InverterState::kEnabled);
    CHECK_FALSE(state.dropped);
  }
}

// MST-065: once in this drive, and disabled since.
TEST(InverterDrop, WhoWasEnabledOnceIsWatchedUntilTheDriveEnds) {
  is(InverterState::kEnabled);
  is(InverterState::kDisabled);
  is(InverterState::kOff);
  CHECK(state.dropped);
  for (const bool ready : {true, false, false}) {  // for as long as it is out, which ends the drive
    is(InverterState::kOff, true, ready);
    CHECK(state.dropped);
  }
}

// MST-065
TEST(InverterDrop, OutsideADriveAndBeforeItIsEnabledNobodyDropsOut) {
  is(InverterState::kEnabled, true, false);
  is(InverterState::kOff, true, false);
  CHECK_FALSE(state.dropped);
  is(InverterState::kDisabled);
  is(InverterState::kOff);
  CHECK_FALSE(state.dropped);
  is(InverterState::kEnabled, false);  // was it ever? nobody has heard it
  is(InverterState::kOff);
  CHECK_FALSE(state.dropped);
}
