// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_command.hpp"

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(InverterCommand) {
  std::int32_t current(std::int32_t ma) {
    return inverter_command(Current::from_raw(ma), DriveState::kReadyToDrive, bench::good(InverterState::kEnabled))
        .phase_current.raw();
  }
};

// MST-040
TEST(InverterCommand, CurrentIsRoundedTowardsZero) {
  LONGS_EQUAL(0, current(99));
  LONGS_EQUAL(100, current(100));
  LONGS_EQUAL(100, current(199));
  LONGS_EQUAL(-100, current(-199));
  LONGS_EQUAL(0, current(-99));
}

// MST-040
TEST(InverterCommand, EnabledOnlyWhenReadyToDrive) {
  for (int mode = 0; mode <= 5; ++mode) {
    const bool ready = static_cast<DriveState>(mode) == DriveState::kReadyToDrive;
    const InverterCommand c = inverter_command(Current::from_raw(1'000), static_cast<DriveState>(mode),
                                               bench::good(InverterState::kDisabled));
    CHECK_EQUAL(ready, c.enable);
    LONGS_EQUAL(ready ? 1'000 : 0, c.phase_current.raw());
  }
}

// MST-040
TEST(InverterCommand, EnabledOnlyForAnInverterThatIsAble) {
  for (int code = 0; code <= 4; ++code) {
    const auto state = static_cast<InverterState>(code);
    const bool able = state == InverterState::kDisabled || state == InverterState::kEnabled;
    CHECK_EQUAL(able, inverter_command(Current{}, DriveState::kReadyToDrive, bench::good(state)).enable);
  }
  for (const Quality quality : {Quality::kNone, Quality::kInvalid, Quality::kStale}) {
    const Sample<InverterState> was{InverterState::kEnabled, Instant{}, quality};
    CHECK_FALSE(inverter_command(Current{}, DriveState::kReadyToDrive, was).enable);
  }
}

// MST-068, MST-069: torque only of four that all obey, and the command is what the four have together.
TEST(InverterCommand, FourHaveTheirPartsOnceAllObey) {
  Config config;
  config.inverter_protocol = InverterProtocol::kAmk;
  config.motor_current_max = Current::from_raw(40'000);
  config.front_drive_share = Ratio::from_raw(300'000);
  InverterCommand all;
  all.enable = true;
  all.phase_current = Current::from_raw(150'100);
  all.limit = Current::from_raw(200'000);
  const InverterCommand four = wheel_command(config, all, bench::good(InverterState::kEnabled));
  CHECK(four.enable && four.limit == all.limit);
  LONGS_EQUAL(22'515, four.wheel.of[0].raw());
  LONGS_EQUAL(40'000, four.wheel.of[3].raw());  // of 52.535 A
  LONGS_EQUAL(125'030, four.phase_current.raw());

  const auto check_none = [&](const InverterCommand& command, const Sample<InverterState>& worst) {
    const InverterCommand out = wheel_command(config, command, worst);
    CHECK_EQUAL(command.enable, out.enable);
    LONGS_EQUAL(0, out.phase_current.raw());
    for (const Current current : out.wheel.of) LONGS_EQUAL(0, current.raw());
  };
  check_none(all, bench::good(InverterState::kDisabled));
  check_none(all, Sample<InverterState>{InverterState::kEnabled, Instant{}, Quality::kStale});
  all.enable = false;
  check_none(all, bench::good(InverterState::kEnabled));
}
