// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/aero.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Aero) {
  VehicleParameters car = vtm16e();
};

TEST(Aero, DragAtTwentyMetresASecondIsHalfCARhoVSquared) {
  DOUBLES_EQUAL(0.5 * 0.372 * 1.225 * 400.0, drag_force(car, 20.0), 1e-9);
}

TEST(Aero, DragOpposesTheDirectionOfTravel) {
  DOUBLES_EQUAL(-drag_force(car, 12.0), drag_force(car, -12.0), 0.0);
  DOUBLES_EQUAL(0.0, drag_force(car, 0.0), 0.0);
}

TEST(Aero, DownforcePressesTheCarDownInBothDirections) {
  DOUBLES_EQUAL(0.5 * 0.014 * 0.12 * 1.225 * 400.0, downforce(car, 20.0), 1e-9);
  DOUBLES_EQUAL(downforce(car, 20.0), downforce(car, -20.0), 0.0);
}
