// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/charger.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Charger) {
  Charger charger{vtm16e().charger};  // 3.3 kW, 32 A, 0.5 s
  void setup() override { charger.plugged = true; }
  void run(double seconds, double link_v, bool connected = true) {
    for (double t = 0.0; t < seconds - 1e-9; t += 0.01) charger.advance(0.01, link_v, connected);
  }
};

TEST(Charger, FollowsItsCommandWithItsTimeConstant) {
  charger.command(110.0, 10.0, true);
  run(0.5, 90.0);
  DOUBLES_EQUAL(10.0 * (1.0 - std::exp(-1.0)), charger.current_a(), 1e-6);
  run(5.0 - 0.6, 90.0);
  DOUBLES_EQUAL(10.0, charger.current_a(), 1e-2);
}

TEST(Charger, GivesNoMoreThanItsPowerAndItsCurrent) {
  charger.command(200.0, 100.0, true);
  run(4.9, 90.0);
  DOUBLES_EQUAL(32.0, charger.current_a(), 0.01);
  charger.command(200.0, 100.0, true);
  run(4.9, 150.0);
  DOUBLES_EQUAL(22.0, charger.current_a(), 0.01);
}

TEST(Charger, StopsFiveSecondsAfterTheLastCommand) {
  charger.command(110.0, 10.0, true);
  run(4.9, 90.0);
  CHECK(charger.current_a() > 9.9 && !charger.silent());
  run(0.11, 90.0);
  CHECK(charger.silent());
  run(5.0, 90.0);
  DOUBLES_EQUAL(0.0, charger.current_a(), 0.0);
}

TEST(Charger, FallsBackWhereTheVoltageIsReached) {
  charger.command(90.0, 10.0, true);
  run(4.9, 95.0);
  DOUBLES_EQUAL(0.0, charger.current_a(), 0.05);
}

TEST(Charger, GivesNothingOffOrFailedOrWithoutABattery) {
  charger.command(110.0, 10.0, true);
  run(2.0, 90.0);
  charger.advance(0.01, 90.0, false);
  DOUBLES_EQUAL(0.0, charger.current_a(), 0.0);
  charger.failed = true;
  run(2.0, 90.0);
  DOUBLES_EQUAL(0.0, charger.current_a(), 0.0);
  charger.failed = false;
  charger.command(110.0, 10.0, false);
  run(2.0, 90.0);
  DOUBLES_EQUAL(0.0, charger.current_a(), 0.0);
}
