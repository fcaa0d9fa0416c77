// SPDX-License-Identifier: Apache-2.0
// What the ceilings are made from: wheels that are good, sensors that are lost.
#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"
#include "master/arbitration.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(ArbitrationSensors) {
  Config config{};
  Input in = bench::healthy(config);
  ArbitrationState state{};

  void step() { arbitration_step(config, in, Current{}, Duration::from_ms(bench::kStepMs), state); }
};

// MST-035
TEST(ArbitrationSensors, TheSlowestGoodWheelCountsWhicheverItIs) {
  for (int slowest = 0; slowest < 4; ++slowest) {
    for (int bad = -1; bad < 4; ++bad) {
      for (int i = 0; i < 4; ++i) {
        in.wheel_speed[i] = bench::good(Speed::from_raw(i == slowest ? 3'000 : 9'000 + i));
        if (i == bad) in.wheel_speed[i] = Sample<Speed>{Speed::from_raw(1), in.now, Quality::kInvalid};
      }
      const Sample<Speed> lowest = lowest_wheel_speed(in);
      CHECK(lowest.good());
      CHECK_EQUAL(slowest != bad, lowest.value.raw() == 3'000);
      CHECK(lowest.value.raw() > 1);
    }
  }
}

TEST(ArbitrationSensors, EverySensorThatIsLostIsNamed) {
  const struct {
    Quality* quality;
    MasterFault fault;
  } rows[] = {{&in.pack_current.quality, MasterFault::kPackSensorLost},
              {&in.pack_voltage.quality, MasterFault::kPackSensorLost},
              {&in.motor_temperature.quality, MasterFault::kMotorTemperatureLost},
              {&in.inverter_temperature.quality, MasterFault::kMotorTemperatureLost}};
  for (const auto& row : rows) {
    *row.quality = Quality::kStale;
    step();
    Faults expected;
    expected.set(row.fault);
    LONGS_EQUAL(expected.bits, state.faults.bits);
    *row.quality = Quality::kGood;
    step();
    CHECK_FALSE(state.faults.any());
  }
}

TEST_GROUP(RegenerationAtLowSpeed) {
  Config config{};
  Input in = bench::healthy(config);
  ArbitrationState state{};

  void setup() override { in.motor_speed.value = MotorSpeed::from_raw(1'000); }
  void wheels(std::int32_t mmps) {
    for (Sample<Speed>& wheel : in.wheel_speed) wheel.value = Speed::from_raw(mmps);
  }
  std::int32_t brakes(int steps = 1) {
    for (; steps > 0; --steps) {
      arbitration_step(config, in, Current::from_raw(-100'000), Duration::from_ms(bench::kStepMs), state);
    }
    return state.current.raw();
  }
};

// MST-035: what is commanded now acts when the wheels are slower.
TEST(RegenerationAtLowSpeed, ItEndsBeforeAWheelThatSlowsDownIsAtFiveKilometresPerHour) {
  wheels(1'790);
  CHECK(brakes(60) < 0);
  wheels(1'690);  // 10 m/s^2: 1'390 in 30 ms
  CHECK(brakes() < 0);
  wheels(1'589);
  LONGS_EQUAL(0, brakes());
  wheels(1'600);  // faster again
  CHECK(brakes(60) < 0);
  in.wheel_speed[0].quality = in.wheel_speed[1].quality = in.wheel_speed[2].quality = Quality::kInvalid;
  brakes();
  for (Sample<Speed>& wheel : in.wheel_speed) wheel.quality = Quality::kGood;
  wheels(1'390);  // of before nothing is known
  CHECK(brakes() < 0);
  wheels(1'300);
  brakes();
  wheels(1'389);  // faster, and not yet fast enough
  LONGS_EQUAL(0, brakes());
  LONGS_EQUAL(0, brakes());
}
