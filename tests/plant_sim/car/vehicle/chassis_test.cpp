// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/chassis.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Chassis) {
  VehicleParameters car = vtm16e();
};

TEST(Chassis, AxleLoadsSumToWeightAndDownforce) {
  for (const double a : {-12.0, 0.0, 6.0}) {
    const AxleLoads loads = axle_loads(car, a, 25.0);
    DOUBLES_EQUAL(315.0 * 9.81 + downforce(car, 25.0), loads.front_n + loads.rear_n, 1e-9);
  }
}

TEST(Chassis, AtRestTheAxlesShareTheWeightByTheCentreOfGravity) {
  const AxleLoads loads = axle_loads(car, 0.0, 0.0);
  DOUBLES_EQUAL(0.48 * 315.0 * 9.81, loads.front_n, 1e-9);
  DOUBLES_EQUAL(0.52 * 315.0 * 9.81, loads.rear_n, 1e-9);
}

TEST(Chassis, SpeedingUpLoadsTheRearAndBrakingTheFront) {
  const AxleLoads rest = axle_loads(car, 0.0, 0.0);
  DOUBLES_EQUAL(rest.rear_n + 315.0 * 5.0 * 0.33 / 1.54, axle_loads(car, 5.0, 0.0).rear_n, 1e-9);
  DOUBLES_EQUAL(rest.front_n + 315.0 * 5.0 * 0.33 / 1.54, axle_loads(car, -5.0, 0.0).front_n, 1e-9);
}

TEST(Chassis, ALiftedAxleCarriesNothing) {
  DOUBLES_EQUAL(0.0, axle_loads(car, 60.0, 0.0).front_n, 0.0);
  DOUBLES_EQUAL(0.0, axle_loads(car, -60.0, 0.0).rear_n, 0.0);
}
