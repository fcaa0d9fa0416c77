// SPDX-License-Identifier: Apache-2.0
#include "race/time_to_safe_state.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(TimeToSafeState) {
  TimeToSafeState watch{0.01};
  std::vector<LostNode> lost;
  std::uint32_t tick = 100;

  void pass(int ticks, bool torque, bool closed) {
    for (; ticks > 0; --ticks) watch.observe(tick++, lost, torque, closed);
  }
};

TEST(TimeToSafeState, NothingIsLostByDefault) {
  pass(1000, true, true);
  CHECK_FALSE(watch.car_is_lost());
  CHECK_FALSE(watch.settled());
  CHECK(watch.rows().empty());
}

TEST(TimeToSafeState, TimesRunFromTheLossToTheLastTickWithTorqueAndWithClosedContactors) {
  pass(10, true, true);
  lost.push_back({"bms", true});
  pass(7, true, true);
  pass(11, false, true);
  pass(100, false, false);
  const auto rows = watch.rows();
  LONGS_EQUAL(1, rows.size());
  STRCMP_EQUAL("bms", rows[0].node.c_str());
  DOUBLES_EQUAL(1.10, rows[0].time_s, 1e-9);
  DOUBLES_EQUAL(0.07, *rows[0].torque_zero_s, 1e-9);
  DOUBLES_EQUAL(0.18, *rows[0].contactors_open_s, 1e-9);
}

TEST(TimeToSafeState, TorqueThatComesBackCountsToItsEnd) {
  lost.push_back({"master", true});
  pass(5, true, true);
  pass(5, false, true);
  pass(5, true, true);
  pass(100, false, false);
  DOUBLES_EQUAL(0.15, *watch.rows()[0].torque_zero_s, 1e-9);
}

TEST(TimeToSafeState, WhatNeverHappenedHasNoTime) {
  lost.push_back({"bms", true});
  pass(300, true, true);
  CHECK_FALSE(watch.rows()[0].torque_zero_s.has_value());
  CHECK_FALSE(watch.rows()[0].contactors_open_s.has_value());
}

TEST(TimeToSafeState, ItIsSettledASecondAfterTheFirstControlUnitWasLost) {
  lost.push_back({"logger", false});
  pass(200, false, false);
  CHECK_FALSE(watch.car_is_lost());
  lost.push_back({"bms", true});
  pass(100, false, false);
  CHECK(watch.car_is_lost());
  CHECK_FALSE(watch.settled());
  lost.push_back({"master", true});
  pass(1, false, false);
  CHECK(watch.settled());
  LONGS_EQUAL(3, watch.rows().size());
}
