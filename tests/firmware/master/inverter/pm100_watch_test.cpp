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
  bool step(std::int32_t ms = 10) {
    in.now = in.now + Duration::from_ms(ms);
    watch_pm100(in, state);
    return state.implausible;
  }
};

// MST-066
TEST(Pm100Watch, AStandingSpeedIsTakenForFrozenWhenTheWheelsGoOn) {
  CHECK_FALSE(step());
  wheels(9'000);
  CHECK_FALSE(step());
  wheels(9'001);
  CHECK(step());
  wheels(6'999);
  CHECK(step());
  in.motor_speed.value = MotorSpeed::from_raw(900);
  CHECK_FALSE(step());
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
