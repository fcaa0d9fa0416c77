// SPDX-License-Identifier: Apache-2.0
#include "race/start_up.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(StartUp) {
  StartUp start_up;
  Switches switches;
  int tick = 0;

  /// Passes `seconds` in ticks of 10 ms while the BMS stays in a state.
  void let_pass(double seconds, can::BmsState bms) {
    for (const int end = tick + static_cast<int>(seconds * 100.0); tick < end; ++tick) {
      start_up.press(tick * 0.01, 0.01, bms, switches);
    }
  }
};

TEST(StartUp, TheTractiveSystemIsAskedForOnceEverySensorWasHeard) {
  let_pass(0.5, can::BmsState::kIdle);
  CHECK_FALSE(switches.ts_on);
  let_pass(0.01, can::BmsState::kIdle);
  CHECK(switches.ts_on);
  CHECK_FALSE(switches.ready_to_drive);
}

TEST(StartUp, ReadyToDriveIsAskedForWhenTheLimitsHaveRisenAfterPrecharge) {
  let_pass(1.0, can::BmsState::kIdle);
  let_pass(1.98, can::BmsState::kTsActive);
  CHECK_FALSE(switches.ts_on || switches.ready_to_drive);
  let_pass(0.03, can::BmsState::kTsActive);
  CHECK(switches.ready_to_drive);
}

TEST(StartUp, ATractiveSystemThatFallsOffBeginsAnew) {
  let_pass(1.0, can::BmsState::kIdle);
  let_pass(1.5, can::BmsState::kTsActive);
  let_pass(0.1, can::BmsState::kIdle);
  CHECK(switches.ts_on);
  let_pass(1.9, can::BmsState::kTsActive);
  CHECK_FALSE(switches.ready_to_drive);
}
