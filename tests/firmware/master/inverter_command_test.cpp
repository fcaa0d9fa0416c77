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
  CHECK_FALSE(inverter_command(Current{}, DriveState::kReadyToDrive, Sample<InverterState>{}).enable);
}
