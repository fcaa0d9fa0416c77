// SPDX-License-Identifier: Apache-2.0
#include "master/torque_split.hpp"

#include <random>

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::master;

namespace {

Config with(std::int32_t drive_ppm, std::int32_t brake_ppm, std::int32_t motor_ma) {
  Config config;
  config.inverter_protocol = InverterProtocol::kAmk;
  config.front_drive_share = Ratio::from_raw(drive_ppm);
  config.front_brake_share = Ratio::from_raw(brake_ppm);
  config.motor_current_max = Current::from_raw(motor_ma);
  return config;
}

}  // namespace

TEST_GROUP(TorqueSplit){};

// MST-069
TEST(TorqueSplit, FrontAndRearHaveTheirSharesInDrivingAndInBraking) {
  const Config config = with(300'000, 600'000, 80'000);
  const WheelCurrents drive = split_torque(config, Current::from_raw(100'000));
  LONGS_EQUAL(15'000, drive.of[0].raw());
  LONGS_EQUAL(15'000, drive.of[1].raw());
  LONGS_EQUAL(35'000, drive.of[2].raw());
  LONGS_EQUAL(35'000, drive.of[3].raw());
  const WheelCurrents brake = split_torque(config, Current::from_raw(-100'000));
  LONGS_EQUAL(-30'000, brake.of[0].raw());
  LONGS_EQUAL(-20'000, brake.of[3].raw());
}

// MST-069
TEST(TorqueSplit, WhatOneAxleCannotGiveTheOtherIsNotGiven) {
  const WheelCurrents out = split_torque(with(200'000, 500'000, 50'000), Current::from_raw(200'000));
  LONGS_EQUAL(50'000, out.of[2].raw());  // of 80 A
  LONGS_EQUAL(20'000, out.of[0].raw());
  LONGS_EQUAL(140'000, out.sum().raw());
}

// MST-069
TEST(TorqueSplit, WhateverIsDrawnTheSumIsKeptAndNoLimitIsPassed) {
  const unsigned seed = std::random_device{}();
  std::mt19937 draw(seed);
  const auto between = [&](std::int32_t low, std::int32_t high) {
    return std::uniform_int_distribution<std::int32_t>(low, high)(draw);
  };
  int at_limit = 0;
  for (int k = 0; k < 200'000; ++k) {
    const Config config = with(between(0, 1'000'000), between(0, 1'000'000), between(1, 200'000));
    const Current all = Current::from_raw(between(-550'000, 550'000));
    const WheelCurrents out = split_torque(config, all);
    bool limited = false;
    for (const Current current : out.of) {
      CHECK_TRUE(-config.motor_current_max <= current && current <= config.motor_current_max);
      CHECK_TRUE(all >= Current{} ? current >= Current{} : current <= Current{});
      limited = limited || current == config.motor_current_max || current == -config.motor_current_max;
    }
    CHECK_TRUE(out.of[0] == out.of[1] && out.of[2] == out.of[3]);
    const std::int32_t lost = all >= Current{} ? (all - out.sum()).raw() : (out.sum() - all).raw();
    CHECK_TRUE(lost >= 0);
    if (!limited && lost > 4) FAIL("more is lost than rounding takes");
    at_limit += limited ? 1 : 0;
  }
  CHECK(at_limit > 1'000 && at_limit < 199'000);
}
