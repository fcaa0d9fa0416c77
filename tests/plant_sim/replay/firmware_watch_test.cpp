// SPDX-License-Identifier: Apache-2.0
#include "replay/firmware_watch.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(FirmwareWatch) {
  ReplayResult result;
  Said said;
  LoggedMoment logged;

  void setup() override {
    said.bms.state = can::BmsState::kTsActive;
    said.limits.discharge_limit_ma = 100'000;
    said.limits.discharge_reason = can::LimitReason::kCellVoltage;
    said.limits.limiting_cell = 4;
  }
  void over(FirmwareWatch& watch, int from, int to, double current_a) {
    logged.current_a = current_a;
    for (int tick = from; tick < to; ++tick) watch.tick(0.01 * tick, said, logged);
  }
};

TEST(FirmwareWatch, a_current_beyond_the_limit_is_a_stretch_with_its_worst_and_its_cell) {
  FirmwareWatch watch(result, true);
  over(watch, 0, 100, 90.0);
  over(watch, 100, 150, 130.0);
  over(watch, 150, 151, 150.0);
  over(watch, 151, 300, 90.0);
  watch.finish();
  LONGS_EQUAL(1, result.over_limits.size());
  const OverLimit& found = result.over_limits[0];
  DOUBLES_EQUAL(1.0, found.begin_s, 1e-9);
  DOUBLES_EQUAL(1.5, found.end_s, 1e-9);
  DOUBLES_EQUAL(150.0, found.current_a, 1e-9);
  DOUBLES_EQUAL(100.0, found.limit_a, 1e-9);
  LONGS_EQUAL(5, found.cell);
}

TEST(FirmwareWatch, nothing_is_beyond_a_limit_that_has_no_model_behind_it) {
  FirmwareWatch watch(result, false);
  over(watch, 0, 100, 500.0);
  watch.finish();
  CHECK(result.over_limits.empty());
}

TEST(FirmwareWatch, with_open_contactors_nothing_is_allowed_and_nothing_counts) {
  FirmwareWatch watch(result, true);
  said.bms.state = can::BmsState::kFault;
  over(watch, 0, 100, 500.0);
  watch.finish();
  CHECK(result.over_limits.empty());
}

TEST(FirmwareWatch, a_fault_is_told_once_and_again_when_it_comes_again) {
  FirmwareWatch watch(result, true);
  over(watch, 0, 10, 0.0);
  for (int round = 0; round < 2; ++round) {
    said.bms.faults = 1U << static_cast<unsigned>(can::BmsFault::kCellVoltageLow);
    said.bms.state = can::BmsState::kFault;
    over(watch, 10 + 20 * round, 20 + 20 * round, 0.0);
    said.bms.faults = 0;
    said.bms.state = can::BmsState::kTsActive;
    over(watch, 20 + 20 * round, 30 + 20 * round, 0.0);
  }
  LONGS_EQUAL(2, result.faults.size());
  STRCMP_EQUAL("CellVoltageLow", result.faults[0].id.c_str());
  CHECK(result.faults[0].opens);
  DOUBLES_EQUAL(0.3, result.faults[1].time_s, 1e-9);
}

TEST(FirmwareWatch, what_is_missing_at_power_on_is_no_fault_yet) {
  FirmwareWatch watch(result, true);
  said.bms.state = can::BmsState::kInvalid;
  said.bms.faults = 1U << static_cast<unsigned>(can::BmsFault::kMasterLost);
  over(watch, 0, 10, 0.0);
  CHECK(result.faults.empty());
}
