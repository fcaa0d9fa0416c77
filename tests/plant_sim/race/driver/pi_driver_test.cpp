// SPDX-License-Identifier: Apache-2.0
#include "race/driver/pi_driver.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(PiDriver) {
  DriverSection section = vtm16e().driver;
  PiDriver driver{section};
};

TEST(PiDriver, WithoutErrorTheBasePedalIsPressed) {
  DOUBLES_EQUAL(0.18, driver.advance({10.0, 0.0, 0.18, 0.0}, 10.0, 0.001).accelerator, 1e-12);
  const Pedals braking = driver.advance({10.0, -5.0, 0.0, 0.9}, 10.0, 0.001);
  DOUBLES_EQUAL(0.9, braking.brake, 1e-12);
  DOUBLES_EQUAL(0.0, braking.accelerator, 0.0);
}

TEST(PiDriver, ProportionalAndIntegralPartFollowTheirGains) {
  constexpr double kError = 0.01;
  for (int i = 1; i <= 100; ++i) {
    const double expected = 0.18 + 10.0 * kError + 1.0 * kError * 0.001 * i;
    DOUBLES_EQUAL(expected, driver.advance({10.0, 0.0, 0.18, 0.0}, 10.0 - kError, 0.001).accelerator, 1e-12);
  }
}

TEST(PiDriver, TheBrakeServesBelowMinusZeroPointTwoAndTheAcceleratorAbove) {
  CHECK(driver.advance({10.0, -0.21, 0.0, 0.9}, 10.0, 0.001).brake > 0.0);
  const Pedals above = driver.advance({10.0, -0.19, 0.18, 0.9}, 10.0, 0.001);
  DOUBLES_EQUAL(0.0, above.brake, 0.0);
  DOUBLES_EQUAL(0.18, above.accelerator, 1e-12);
}

TEST(PiDriver, OnARoadWhoIsTooFastBrakesAndNoPedalGoesBeyondTheGrip) {
  const RoadSense road{.follows_road = true, .accelerator_most = 0.4, .brake_most = 0.3, .coasting_mps2 = -1.0};
  DOUBLES_EQUAL(0.4, driver.advance({10.0, 2.0, 0.8, 0.0}, 9.0, 0.001, road).accelerator, 0.0);
  DOUBLES_EQUAL(0.3, driver.advance({10.0, -5.0, 0.0, 0.9}, 11.0, 0.001, road).brake, 0.0);
  DOUBLES_EQUAL(0.3, driver.advance({10.0, 0.0, 0.18, 0.0}, 11.0, 0.001, road).brake, 0.0);
  DOUBLES_EQUAL(0.0, driver.advance({10.0, 0.0, 0.18, 0.0}, 10.0, 0.001, road).brake, 0.0);
  // A target that slows down less than the car does by itself needs the accelerator.
  CHECK(driver.advance({10.0, -0.9, 0.18, 0.9}, 9.99, 0.001, road).accelerator > 0.0);
}

TEST(PiDriver, BrakeRisesWhenTheCarIsTooFast) {
  const double slow = driver.advance({10.0, -5.0, 0.0, 0.5}, 9.995, 0.001).brake;
  const double fast = driver.advance({10.0, -5.0, 0.0, 0.5}, 10.005, 0.001).brake;
  CHECK(slow < 0.5 && 0.5 < fast);
}

TEST(PiDriver, PedalsStayBetweenZeroAndOne) {
  DOUBLES_EQUAL(1.0, driver.advance({30.0, 1.0, 0.8, 0.0}, 0.0, 0.001).accelerator, 0.0);
  DOUBLES_EQUAL(0.0, driver.advance({0.0, 0.0, 0.18, 0.0}, 30.0, 0.001).accelerator, 0.0);
  DOUBLES_EQUAL(1.0, driver.advance({0.0, -1.0, 0.0, 0.9}, 30.0, 0.001).brake, 0.0);
}

TEST(PiDriver, AMinuteHeldAtStandstillDoesNotWindTheIntegralUp) {
  for (int ms = 0; ms < 60000; ++ms) driver.advance({10.0, 1.0, 0.8, 0.0}, 0.0, 0.001);
  // At the target again: the pedal is the base, not a stored minute of error.
  DOUBLES_EQUAL(0.8, driver.advance({10.0, 1.0, 0.8, 0.0}, 10.0, 0.001).accelerator, 1e-9);
}

TEST(PiDriver, ACarThatStandsInABrakingZoneIsDrivenOn) {
  const Pedals standing = driver.advance({16.0, -5.0, 0.0, 0.9}, 0.0, 0.001);
  DOUBLES_EQUAL(1.0, standing.accelerator, 0.0);
  DOUBLES_EQUAL(0.0, standing.brake, 0.0);
}

TEST(PiDriver, WhoCatchesUpBrakesWhenHeMeetsTheTargetAgain) {
  CHECK(driver.advance({16.0, -5.0, 0.0, 0.9}, 14.9, 0.001).accelerator > 0.0);
  CHECK(driver.advance({15.5, -5.0, 0.0, 0.9}, 15.4, 0.001).accelerator > 0.0);
  CHECK(driver.advance({15.4, -5.0, 0.0, 0.9}, 15.4, 0.001).brake > 0.0);
  // Slower than the target by less than a metre per second he goes on braking.
  CHECK(driver.advance({15.3, -5.0, 0.0, 0.9}, 14.4, 0.001).accelerator == 0.0);
}

TEST(PiDriver, EveryEventStartsWithAnEmptyIntegral) {
  for (int ms = 0; ms < 1000; ++ms) driver.advance({10.0, 0.0, 0.18, 0.0}, 9.99, 0.001);
  driver.advance({10.0, -5.0, 0.0, 0.5}, 10.0, 0.001);
  DOUBLES_EQUAL(0.18, driver.advance({10.0, 0.0, 0.18, 0.0}, 10.0, 0.001).accelerator, 1e-12);
}
