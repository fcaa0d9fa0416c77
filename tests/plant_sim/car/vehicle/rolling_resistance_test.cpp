// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/rolling_resistance.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(RollingResistance) {
  VehicleParameters car = vtm16e();
};

TEST(RollingResistance, IsAHundredthOfTheWeightWithDriver) {
  DOUBLES_EQUAL(0.01 * 315.0 * 9.81, rolling_force(car, 10.0), 1e-9);
  DOUBLES_EQUAL(-0.01 * 315.0 * 9.81, rolling_force(car, -10.0), 1e-9);
}

TEST(RollingResistance, DoesNotPushAStandingCar) {
  DOUBLES_EQUAL(0.0, rolling_force(car, 0.0), 0.0);
  DOUBLES_EQUAL(0.5 * rolling_force(car, 1.0), rolling_force(car, 0.025), 1e-9);
}
