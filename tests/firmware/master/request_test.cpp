// SPDX-License-Identifier: Apache-2.0
#include "master/request.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(Request) {
  Config config{};
  Input in = bench::healthy(config);
  PedalState pedals{};
  RequestState state{};
  DriveState mode = DriveState::kReadyToDrive;

  void setup() override {
    pedals.released = true;
    run();
    pedals.released = false;
  }
  std::int32_t run(std::int32_t position_ppm = 0, std::int32_t elapsed_ms = bench::kStepMs) {
    pedals.position = Ratio::from_raw(position_ppm);
    request_step(config, in, pedals, mode, Duration::from_ms(elapsed_ms), state);
    return state.current.raw();
  }
  std::int32_t settle(std::int32_t position_ppm) {
    for (int i = 0; i < 10; ++i) run(position_ppm);
    return state.current.raw();
  }
};

TEST(Request, PedalIsLinearFromZeroTo550Ampere) {
  LONGS_EQUAL(0, settle(0));
  LONGS_EQUAL(0, settle(1));        // 0.55 mA
  LONGS_EQUAL(1, settle(2));
  LONGS_EQUAL(275'000, settle(500'000));
  LONGS_EQUAL(549'999, settle(999'999));
  LONGS_EQUAL(550'000, settle(1'000'000));
}

TEST(Request, MapIsAParabolaThatRisesFromEndToEnd) {
  for (const std::int32_t half : {250'000, 400'000, 500'000, 600'000, 750'000}) {
    const auto at = [half](std::int32_t travel) {
      return request_at(Ratio::from_raw(travel), Ratio::from_raw(half)).raw();
    };
    LONGS_EQUAL(0, at(0));
    LONGS_EQUAL(half, at(500'000));
    LONGS_EQUAL(1'000'000, at(1'000'000));
    for (std::int32_t travel = 1'000; travel <= 1'000'000; travel += 1'000) CHECK(at(travel) >= at(travel - 1'000));
  }
  LONGS_EQUAL(62'500, request_at(Ratio::from_raw(250'000), Ratio::from_raw(250'000)).raw());  // p^2
  config.pedal_at_half = Ratio::from_raw(250'000);
  LONGS_EQUAL(137'500, settle(500'000));
}

TEST(Request, DeadZoneIsTakenOffAndTheRestSpansTheWholeRange) {
  const Ratio zone = Ratio::from_raw(50'000);
  LONGS_EQUAL(0, beyond_dead_zone(Ratio{}, zone).raw());
  LONGS_EQUAL(0, beyond_dead_zone(Ratio::from_raw(49'999), zone).raw());
  LONGS_EQUAL(0, beyond_dead_zone(Ratio::from_raw(50'000), zone).raw());
  LONGS_EQUAL(1, beyond_dead_zone(Ratio::from_raw(50'001), zone).raw());
  LONGS_EQUAL(500'000, beyond_dead_zone(Ratio::from_raw(525'000), zone).raw());
  LONGS_EQUAL(1'000'000, beyond_dead_zone(Ratio::from_raw(1'000'000), zone).raw());
}

// MST-021
TEST(Request, RisesBy20AmperePerMillisecondAndFallsAtOnce) {
  LONGS_EQUAL(200'000, run(1'000'000));
  LONGS_EQUAL(400'000, run(1'000'000));
  LONGS_EQUAL(550'000, run(1'000'000));  // 30 ms
  LONGS_EQUAL(0, run(0));                // one step
}

// MST-021
TEST(Request, NoTimeMeansNoRise) {
  LONGS_EQUAL(0, run(1'000'000, 0));
  LONGS_EQUAL(20'000, run(1'000'000, 1));
}

// MST-020
TEST(Request, ComesBackOnlyFromAReleasedPedal) {
  settle(600'000);
  in.inverter_state.quality = Quality::kStale;
  LONGS_EQUAL(0, run(600'000));
  in.inverter_state.quality = Quality::kGood;
  LONGS_EQUAL(0, settle(600'000));
  pedals.released = true;
  run(0);
  pedals.released = false;
  LONGS_EQUAL(330'000, settle(600'000));
}

// MST-020
TEST(Request, EveryInterruptionDisarms) {
  config.regen_current_max = Current::from_raw(300'000);
  pedals.brake_pressure = Pressure::from_raw(40'000);
  for (const int what : {0, 1, 2, 3}) {
    pedals.released = true;
    run();
    pedals.released = false;
    LONGS_EQUAL(330'000, settle(600'000));
    if (what == 0) mode = DriveState::kTsActive;
    if (what == 1) pedals.latched.set(MasterFault::kAppsRange);
    if (what == 2) in.inverter_state.value = InverterState::kCommandTimeout;
    if (what == 3) in.inverter_state.value = InverterState::kOff;
    LONGS_EQUAL(0, run(600'000));
    CHECK_FALSE(state.armed);
    LONGS_EQUAL(0, state.pedal.raw());  // as it is told on the bus
    in.now = in.now + Duration::from_ms(100);
    pedals.released = pedals.brake_pressed = true;  // for as long as it lasts a released pedal arms nothing
    LONGS_EQUAL(0, settle(0));
    CHECK_FALSE(state.armed);
    pedals.released = pedals.brake_pressed = false;
    mode = DriveState::kReadyToDrive;
    pedals.latched = Faults{};
    in.inverter_state.value = InverterState::kEnabled;
    LONGS_EQUAL(0, settle(600'000));
  }
}

// MST-020
TEST(Request, InverterThatMissesCommandsForLessThan100MsIsNoInterruption) {
  for (std::int32_t steps = 1; steps <= 8; ++steps) {  // it says so 50 ms after the last command
    for (const int also : {0, 1, 2, 3}) {
      pedals.released = true;
      settle(0);
      pedals.released = false;
      LONGS_EQUAL(330'000, settle(600'000));
      for (std::int32_t k = 0; k < steps; ++k) {
        in.now = in.now + Duration::from_ms(10);
        in.inverter_state.value = InverterState::kCommandTimeout;
        if (also == 1) mode = DriveState::kTsActive;
        if (also == 2) in.inverter_state.value = InverterState::kOff;
        if (also == 3) in.inverter_state.quality = Quality::kStale;
        LONGS_EQUAL(0, run(600'000));
        mode = DriveState::kReadyToDrive;
        in.inverter_state.quality = Quality::kGood;
      }
      in.inverter_state.value = InverterState::kEnabled;
      in.now = in.now + Duration::from_ms(10);
      LONGS_EQUAL(also == 0 && steps < 5 ? 330'000 : 0, settle(600'000));
    }
  }
}

// MST-020: what it did meanwhile is no lost frame.
TEST(Request, InverterThatWentOffAfterItMissedCommandsIsAnInterruption) {
  settle(600'000);
  for (const InverterState is : {InverterState::kCommandTimeout, InverterState::kOff}) {
    in.now = in.now + Duration::from_ms(10);
    in.inverter_state.value = is;
    LONGS_EQUAL(0, run(600'000));
  }
  in.now = in.now + Duration::from_ms(10);
  in.inverter_state.value = InverterState::kEnabled;
  LONGS_EQUAL(0, settle(600'000));
}

// MST-021
TEST(Request, ChangeOfDirectionBeginsAtZero) {
  state.current = Current::from_raw(-150'000);
  LONGS_EQUAL(200'000, run(1'000'000));
}

// MST-022
TEST(Request, BrakeAsksForNoRegenerationByDefault) {
  pedals.released = true;
  pedals.brake_pressed = true;
  pedals.brake_pressure = Pressure::from_raw(40'000);
  LONGS_EQUAL(0, settle(0));
}

// MST-022
TEST(Request, ConfiguredRegenerationFollowsTheBrakeAndIsRateLimited) {
  config.regen_current_max = Current::from_raw(300'000);
  pedals.released = true;
  pedals.brake_pressed = true;
  pedals.brake_pressure = Pressure::from_raw(40'000);
  LONGS_EQUAL(-200'000, run(0));
  LONGS_EQUAL(-300'000, run(0));
  pedals.brake_pressure = Pressure::from_raw(21'500);  // half way from 3 to 40 bar
  LONGS_EQUAL(-150'000, run(0));
  pedals.released = false;
  LONGS_EQUAL(0, run(0));
  LONGS_EQUAL(55'000, run(100'000));  // the accelerator goes before the brake
}

// MST-022
TEST(Request, BrakeBeyondItsLevelsAsksForNoMoreAndBelowThemForNothing) {
  config.regen_current_max = Current::from_raw(300'000);
  pedals.released = true;
  pedals.brake_pressed = true;
  for (const std::int32_t mbar : {40'000, 40'001, 160'000}) {
    pedals.brake_pressure = Pressure::from_raw(mbar);
    LONGS_EQUAL(-300'000, settle(0));
  }
  pedals.brake_pressed = false;
  for (const std::int32_t mbar : {0, 1'000, 3'000}) {
    pedals.brake_pressure = Pressure::from_raw(mbar);
    LONGS_EQUAL(0, settle(0));
  }
}
