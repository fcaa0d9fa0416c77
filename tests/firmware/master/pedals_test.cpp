// SPDX-License-Identifier: Apache-2.0
#include "master/pedals.hpp"

#include <utility>

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(Pedals) {
  Config config{};
  Input in = bench::healthy(config);
  PedalState state{};

  void run(std::int32_t steps = 1) {
    for (std::int32_t i = 0; i < steps; ++i) {
      in.now = in.now + Duration::from_ms(bench::kStepMs);
      pedals_step(config, in, state);
    }
  }
  /// Steps of 10 ms until something latches.
  std::int32_t ms_until_latched() {
    const Instant begin = in.now + Duration::from_ms(bench::kStepMs);
    for (int i = 0; i < 100; ++i) {
      run();
      if (state.latched.any()) return (in.now - begin).ms();
    }
    return -1;
  }
};

TEST(Pedals, TravelIsLinearAndClipped) {
  CHECK_EQUAL(0, apps_travel(config.apps1, Potential::from_raw(4'999)).raw());
  CHECK_EQUAL(0, apps_travel(config.apps1, Potential::from_raw(5'000)).raw());
  CHECK_EQUAL(25, apps_travel(config.apps1, Potential::from_raw(5'001)).raw());
  CHECK_EQUAL(500'000, apps_travel(config.apps1, Potential::from_raw(25'000)).raw());
  CHECK_EQUAL(999'975, apps_travel(config.apps1, Potential::from_raw(44'999)).raw());
  CHECK_EQUAL(1'000'000, apps_travel(config.apps1, Potential::from_raw(45'001)).raw());
  CHECK_EQUAL(500'000, apps_travel(config.apps2, Potential::from_raw(12'500)).raw());
}

TEST(Pedals, TravelOfAnAllZeroChannelIsZero) {
  CHECK_EQUAL(0, apps_travel(AppsChannel{}, Potential::from_raw(30'000)).raw());
}

TEST(Pedals, TravelOfTheShortestChannelGoesAllTheWay) {
  const AppsChannel channel{Potential::from_raw(100), Potential::from_raw(101), Potential{}, Potential{}};
  CHECK_EQUAL(0, apps_travel(channel, Potential::from_raw(100)).raw());
  CHECK_EQUAL(1'000'000, apps_travel(channel, Potential::from_raw(101)).raw());
}

TEST(Pedals, PositionIsTheLowerOfTheTwoSensors) {
  in.apps1.value = bench::volts(config.apps1, 500);
  in.apps2.value = bench::volts(config.apps2, 450);
  run();
  CHECK_EQUAL(450'000, state.position.raw());
}

TEST(Pedals, AllZeroInputLatchesLostPedalsAndAsksForNothing) {
  in = Input{};
  run();
  CHECK(state.latched.has(MasterFault::kPedalsLost));
  CHECK_EQUAL(0, state.position.raw());
  CHECK_FALSE(state.released);
}

// MST-001
TEST(Pedals, LostPedalsStopTheRequestInTheSameStepAndComeBackReleased) {
  bench::set_pedal(config, 800, in);
  run();
  in.apps1.quality = in.apps2.quality = Quality::kStale;
  CHECK_EQUAL(0, ms_until_latched());
  CHECK_EQUAL(0, state.position.raw());
  in.apps1.quality = in.apps2.quality = Quality::kGood;
  run();
  CHECK_EQUAL(0, state.position.raw());
  bench::set_pedal(config, 49, in);
  run();
  CHECK_EQUAL(49'000, state.position.raw());
}

// MST-001
TEST(Pedals, OneLostSensorIsALostPedal) {
  for (Sample<Potential> Input::*sensor : {&Input::apps1, &Input::apps2}) {
    for (const Quality quality : {Quality::kNone, Quality::kStale}) {
      state = PedalState{};
      bench::set_pedal(config, 800, in);
      run();
      CHECK_EQUAL(800'000, state.position.raw());
      (in.*sensor).quality = quality;
      run();
      CHECK(state.latched.has(MasterFault::kPedalsLost));
      CHECK_EQUAL(0, state.position.raw());
      (in.*sensor).quality = Quality::kGood;
    }
  }
}

// MST-002, MST-003: what cannot be believed does not disagree either.
TEST(Pedals, SensorOutsideItsRangeIsNamedAsThatAlone) {
  in.apps1.value = config.apps1.range_max + Potential::from_raw(1);
  run(50);
  Faults expected;
  expected.set(MasterFault::kAppsRange);
  LONGS_EQUAL(expected.bits, state.latched.bits);
  CHECK_FALSE(state.released);
}

// MST-003: a pedal of two opinions has not been seen released.
TEST(Pedals, SensorsThatDisagreeBelowTheReleaseLevelAreNotReleased) {
  config.apps_disagreement_max = Ratio::from_raw(20'000);
  bench::set_pedal(config, 0, in);
  in.apps1.value = bench::volts(config.apps1, 20);
  run();
  CHECK(state.released);
  in.apps1.value = bench::volts(config.apps1, 40);
  run();
  CHECK_FALSE(state.released);
}

// MST-002
TEST(Pedals, SensorOutsideItsRangeAsksForNothingAtOnceAndLatchesAfter100Ms) {
  bench::set_pedal(config, 1000, in);
  in.apps1.value = config.apps1.range_max;
  run();
  CHECK_EQUAL(1'000'000, state.position.raw());
  in.apps1.value = config.apps1.range_max + Potential::from_raw(1);
  run();
  CHECK_EQUAL(0, state.position.raw());
  CHECK_FALSE(state.latched.any());
  run(9);
  CHECK_FALSE(state.latched.any());
  run();  // 100 ms after the first bad sample
  CHECK(state.latched.has(MasterFault::kAppsRange));
}

// MST-002
TEST(Pedals, SensorShortedToGroundOrOpenIsOutsideItsRange) {
  for (const std::int32_t raw : {0, config.apps2.range_min.raw() - 1, config.apps2.range_max.raw() + 1, 50'000}) {
    state = PedalState{};
    bench::set_pedal(config, 900, in);
    in.apps2.value = Potential::from_raw(raw);
    CHECK_EQUAL(100, ms_until_latched());
    CHECK(state.latched.has(MasterFault::kAppsRange));
  }
}

// MST-002
TEST(Pedals, SensorAtTheEndsOfItsRangeHasNotFailed) {
  in.apps1.value = config.apps1.range_min;
  in.apps2.value = config.apps2.range_min;
  CHECK_EQUAL(-1, ms_until_latched());
  in.apps1.value = config.apps1.range_max;
  in.apps2.value = config.apps2.range_max;
  CHECK_EQUAL(-1, ms_until_latched());
}

// MST-002
TEST(Pedals, SensorMarkedInvalidCountsAsOutsideItsRange) {
  in.apps2.quality = Quality::kInvalid;
  CHECK_EQUAL(100, ms_until_latched());
  CHECK(state.latched.has(MasterFault::kAppsRange));
}

// MST-003
TEST(Pedals, DisagreementOfExactlyTenPercentIsAccepted) {
  in.apps1.value = bench::volts(config.apps1, 600);
  in.apps2.value = bench::volts(config.apps2, 500);
  CHECK_EQUAL(-1, ms_until_latched());
}

// MST-003
TEST(Pedals, DisagreementOfOneStepMoreThanTenPercentLatchesAfter100Ms) {
  in.apps1.value = bench::volts(config.apps1, 600) + Potential::from_raw(1);
  in.apps2.value = bench::volts(config.apps2, 500);
  CHECK_EQUAL(100, ms_until_latched());
  CHECK(state.latched.has(MasterFault::kAppsImplausible));
  CHECK_EQUAL(0, state.position.raw());
}

// MST-006
TEST(Pedals, DisagreementThatPausesTakesUpWhereItWas) {
  in.apps2.value = bench::volts(config.apps2, 200);
  run(10);  // 90 ms
  in.apps2.value = config.apps2.released;
  run();    // takes back 2.5 ms
  in.apps2.value = bench::volts(config.apps2, 200);
  CHECK_EQUAL(20, ms_until_latched());
}

// MST-006
TEST(Pedals, SensorThatFailsHalfOfTheTimeStopsTheTorque) {
  for (const auto& [piece, bound_ms] : {std::pair{2, 800}, std::pair{5, 400}, std::pair{9, 400}}) {
    state = PedalState{};
    bench::set_pedal(config, 900, in);
    const Potential good = in.apps1.value;
    std::int32_t took = -1;
    for (int i = 0; i < 200 && took < 0; ++i) {
      in.apps1.value = i % (2 * piece) < piece ? Potential{} : good;
      run();
      if (state.latched.has(MasterFault::kAppsRange)) took = i * bench::kStepMs;
    }
    CHECK(took >= 100);
    CHECK(took <= bound_ms);
    UT_PRINT(StringFromFormat("MST-006: failed for %d ms of %d: %d ms", piece * 10, piece * 20, took).asCharString());
  }
}

// MST-006
TEST(Pedals, SensorThatFailsForAStepNowAndThenStopsNobody) {
  bench::set_pedal(config, 900, in);
  const Potential good = in.apps1.value;
  for (int i = 0; i < 2000; ++i) {
    in.apps1.value = i % 6 == 0 ? Potential{} : good;
    run();
    CHECK_FALSE(state.latched.any());
  }
}

// MST-004
TEST(Pedals, BrakeSensorFailedFor100MsLatches) {
  in.brake_rear.quality = Quality::kInvalid;
  run(10);  // 90 ms
  CHECK_FALSE(state.latched.any());
  run();
  CHECK(state.latched.has(MasterFault::kBrakeSensor));
}

// MST-004
TEST(Pedals, BrakeSensorThatReturnsInTimeDoesNotLatch) {
  in.brake_rear.quality = Quality::kStale;
  run(10);
  in.brake_rear.quality = Quality::kGood;
  run(20);
  CHECK_FALSE(state.latched.any());
}

// MST-007
TEST(Pedals, OneCircuitThatIsPressedHardWithoutTheOtherIsAFailedSensor) {
  for (const bool front : {true, false}) {
    const auto latched_after = [&](std::int32_t pressed_mbar, std::int32_t other_mbar, std::int32_t steps) {
      PedalState fresh{};
      (front ? in.brake_front : in.brake_rear).value = Pressure::from_raw(pressed_mbar);
      (front ? in.brake_rear : in.brake_front).value = Pressure::from_raw(other_mbar);
      for (std::int32_t i = 0; i < steps; ++i) {
        in.now = in.now + Duration::from_ms(bench::kStepMs);
        pedals_step(config, in, fresh);
      }
      return fresh.latched.has(MasterFault::kBrakeSensor);
    };
    CHECK_FALSE(latched_after(20'001, 3'000, 10));  // 90 ms
    CHECK(latched_after(20'001, 3'000, 11));
    CHECK(latched_after(159'000, 0, 11));
    CHECK_FALSE(latched_after(20'000, 0, 100));
    CHECK_FALSE(latched_after(159'000, 3'001, 100));
    CHECK_FALSE(latched_after(60'000, 30'000, 100));
  }
}

TEST(Pedals, BrakeIsPressedOneStepAboveItsLevelInEitherCircuit) {
  for (Sample<Pressure> Input::*circuit : {&Input::brake_front, &Input::brake_rear}) {
    Sample<Pressure>& brake = in.*circuit;
    brake.value = config.brake_pressed_level;
    run();
    CHECK_FALSE(state.brake_pressed);
    brake.value = config.brake_pressed_level + Pressure::from_raw(1);
    run();
    CHECK(state.brake_pressed);
    LONGS_EQUAL(brake.value.raw(), state.brake_pressure.raw());
    brake.quality = Quality::kInvalid;
    run();
    CHECK_FALSE(state.brake_pressed);
    brake = bench::good(Pressure{});
  }
}

// MST-005
TEST(Pedals, BrakeWithExactly25PercentIsAccepted) {
  bench::set_pedal(config, 250, in);
  bench::set_brake(20'000, in);
  CHECK_EQUAL(-1, ms_until_latched());
}

// MST-005
TEST(Pedals, BrakeWithOneStepMoreThan25PercentLatchesInTheSameStep) {
  bench::set_pedal(config, 250, in);
  in.apps1.value = in.apps1.value + Potential::from_raw(1);
  bench::set_brake(20'000, in);
  CHECK_EQUAL(0, ms_until_latched());
  CHECK(state.latched.has(MasterFault::kBrakeAndThrottle));
  CHECK_EQUAL(0, state.position.raw());
}

// MST-005
TEST(Pedals, PowerComesBackBelow5PercentWhateverTheBrakeDoes) {
  bench::set_pedal(config, 600, in);
  bench::set_brake(20'000, in);
  run();
  bench::set_brake(0, in);
  run(50);
  CHECK(state.latched.has(MasterFault::kBrakeAndThrottle));
  bench::set_pedal(config, 50, in);
  run();
  CHECK(state.latched.has(MasterFault::kBrakeAndThrottle));
  bench::set_brake(20'000, in);
  in.apps1.value = in.apps1.value - Potential::from_raw(1);
  in.apps2.value = in.apps2.value - Potential::from_raw(1);
  run();
  CHECK_FALSE(state.latched.any());
}

TEST(Pedals, ReleasedPedalDoesNotClearWhatStillHolds) {
  in.brake_rear.quality = Quality::kInvalid;
  run(20);
  CHECK(state.released);
  CHECK(state.latched.has(MasterFault::kBrakeSensor));
}
