// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100_watch.hpp"

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
  CHECK_FALSE(step());
  in.wheel_speed[2].quality = Quality::kStale;
  wheels(0);
  in.wheel_speed[2].quality = Quality::kStale;
  CHECK_FALSE(step());
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
  void is(InverterState s, bool good = true) {
    in.inverter_state = {s, in.now, good ? Quality::kGood : Quality::kStale};
    watch_dropping(true, in, state);
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
