// SPDX-License-Identifier: Apache-2.0
#include "master/derating.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(Derating) {
  Config config{};
  Input in = bench::healthy(config);
  std::int32_t with_motor(std::int32_t dc) {
    in.motor_temperature.value = Temperature::from_raw(dc);
    return temperature_ceiling(config, in).raw();
  }
  std::int32_t with_inverter(std::int32_t dc) {
    in.inverter_temperature.value = Temperature::from_raw(dc);
    return temperature_ceiling(config, in).raw();
  }
};

// MST-034
TEST(Derating, MotorIsLinearBetweenItsTwoTemperatures) {
  LONGS_EQUAL(550'000, with_motor(1'399));
  LONGS_EQUAL(550'000, with_motor(1'400));
  LONGS_EQUAL(547'250, with_motor(1'401));
  LONGS_EQUAL(275'000, with_motor(1'500));
  LONGS_EQUAL(2'750, with_motor(1'599));
  LONGS_EQUAL(0, with_motor(1'600));
  LONGS_EQUAL(0, with_motor(2'500));
}

// MST-034
TEST(Derating, InverterIsLinearBetweenItsTwoTemperatures) {
  LONGS_EQUAL(550'000, with_inverter(800));
  CHECK(with_inverter(801) < 550'000);
  LONGS_EQUAL(275'000, with_inverter(875));
  CHECK(with_inverter(949) > 0);
  LONGS_EQUAL(0, with_inverter(950));
}

// MST-034
TEST(Derating, UnknownTemperatureAllowsNothing) {
  for (const Quality q : {Quality::kNone, Quality::kInvalid, Quality::kStale}) {
    in = bench::healthy(config);
    in.motor_temperature.quality = q;
    LONGS_EQUAL(0, temperature_ceiling(config, in).raw());
    in = bench::healthy(config);
    in.inverter_temperature.quality = q;
    LONGS_EQUAL(0, temperature_ceiling(config, in).raw());
  }
  LONGS_EQUAL(0, temperature_ceiling(config, Input{}).raw());
}

TEST(Derating, VeryColdIsNoReasonToDerate) { LONGS_EQUAL(550'000, with_motor(-400)); }

// MST-034
TEST(Derating, UnknownTemperatureLeavesWhatIsSetToDriveHomeWith) {
  config.limp_share = Ratio::from_raw(250'000);
  in.motor_temperature.quality = Quality::kStale;
  LONGS_EQUAL(137'500, temperature_ceiling(config, in).raw());
  LONGS_EQUAL(0, with_inverter(950));  // what is known still counts
}

// MST-038
TEST(Derating, TorqueEndsAtTheHighestMotorSpeedInBothDirections) {
  config.motor_speed_max = MotorSpeed::from_raw(6'000);
  const auto at = [this](std::int32_t rpm) {
    in.motor_speed.value = MotorSpeed::from_raw(rpm);
    return speed_ceiling(config, in).raw();
  };
  for (const std::int32_t sign : {1, -1}) {
    LONGS_EQUAL(550'000, at(sign * 3'000));
    LONGS_EQUAL(550'000, at(sign * 5'880));
    CHECK(at(sign * 5'881) < 550'000);
    LONGS_EQUAL(275'000, at(sign * 5'940));
    CHECK(at(sign * 5'999) > 0);
    LONGS_EQUAL(0, at(sign * 6'000));
    LONGS_EQUAL(0, at(sign * 12'000));
  }
  in.motor_speed.quality = Quality::kStale;
  LONGS_EQUAL(550'000, speed_ceiling(config, in).raw());
}

// MST-034: a configuration that is refused, too, allows nothing at its end.
TEST(Derating, RangeWithoutWidthEndsAtItsEnd) {
  const Temperature end = Temperature::from_raw(900);
  const auto share = [end](std::int32_t dc) {
    return temperature_share(bench::good(Temperature::from_raw(dc)), end, end, Ratio{}).raw();
  };
  LONGS_EQUAL(1'000'000, share(899));
  LONGS_EQUAL(0, share(900));
}

// MST-038
TEST(Derating, WithoutAHighestSpeedNothingDrives) {
  config.motor_speed_max = MotorSpeed{};
  in.motor_speed.value = MotorSpeed{};
  LONGS_EQUAL(0, speed_ceiling(config, in).raw());
}
