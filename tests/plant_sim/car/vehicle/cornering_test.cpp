// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/cornering.hpp"

#include "car/vehicle/longitudinal.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Cornering) { VehicleParameters car = vtm16e(); };

TEST(Cornering, DragIsLateralForceTimesSlipAngleAndOffByDefault) {
  DOUBLES_EQUAL(0.0, cornering_drag(car, 10.0), 0.0);
  car.tyres.cornering_stiffness_per_rad = 20.0;
  const double force = 315.0 * 10.0, slip_angle = force / (20.0 * 315.0 * 9.81);
  DOUBLES_EQUAL(force * slip_angle, cornering_drag(car, 10.0), 1e-9);
  DOUBLES_EQUAL(cornering_drag(car, 10.0), cornering_drag(car, -10.0), 0.0);
}

TEST(Cornering, AHillTakesItsShareOfTheWeight) {
  DOUBLES_EQUAL(0.0, climbing_force(car, 0.0), 0.0);
  DOUBLES_EQUAL(315.0 * 9.81 * 0.1 / 1.00498756, climbing_force(car, 0.1), 1e-3);
  DOUBLES_EQUAL(-climbing_force(car, 0.1), climbing_force(car, -0.1), 0.0);
}

TEST(Cornering, EveryForceOfTheRoadSlowsTheCarAndItsWorkIsInTheBooks) {
  car.tyres.cornering_stiffness_per_rad = 20.0;
  const Road roads[] = {{.lateral_mps2 = 8.0}, {.grade = 0.05}, {.head_wind_mps = 8.0}};
  LongitudinalVehicle level(car);
  level.set_speed(15.0);
  for (int i = 0; i < 1000; ++i) level.advance(0.0, 0.0, 0.001);
  for (const Road& road : roads) {
    LongitudinalVehicle vehicle(car);
    vehicle.set_speed(15.0);
    vehicle.set_road(road);
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i) {
      const VehicleEnergy e = vehicle.advance(0.0, 0.0, 0.001);
      sum += e.kinetic_j + e.climb_j + e.aero_j + e.rolling_j + e.cornering_j + e.slip_j;
    }
    CHECK(vehicle.speed_mps() < level.speed_mps() - 0.05);
    DOUBLES_EQUAL(0.0, sum, 0.05);
  }
}
