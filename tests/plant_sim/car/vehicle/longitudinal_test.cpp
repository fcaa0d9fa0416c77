// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/longitudinal.hpp"

#include <algorithm>
#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(LongitudinalVehicle) {
  VehicleParameters car = vtm16e();
  LongitudinalVehicle vehicle{car};
};

TEST(LongitudinalVehicle, StandsStillWithoutTorqueAndUnderFullBrake) {
  for (const double brake : {0.0, 1.0}) {
    for (int i = 0; i < 1000; ++i) vehicle.advance(0.0, brake, 0.001);
    DOUBLES_EQUAL(0.0, vehicle.speed_mps(), 1e-12);
    DOUBLES_EQUAL(0.0, vehicle.distance_m(), 1e-12);
  }
}

TEST(LongitudinalVehicle, FullTorqueFromRestAcceleratesSteadilyFromTheFirstStep) {
  double before = 0.0, worst_jerk = 0.0;
  for (int i = 0; i < 1000; ++i) {
    vehicle.advance(218.0, 0.0, 0.001);
    CHECK(vehicle.speed_mps() >= before);
    before = vehicle.speed_mps();
    const double a = vehicle.acceleration_mps2();
    vehicle.advance(218.0, 0.0, 0.001);
    if (i > 100) worst_jerk = std::max(worst_jerk, std::abs(vehicle.acceleration_mps2() - a));
  }
  CHECK(worst_jerk < 0.01);
  const double mass = 315.0 + (0.632 + 0.2) / (car.tyres.radius_m * car.tyres.radius_m);
  DOUBLES_EQUAL((218.0 / car.tyres.radius_m - 31.0) / mass * 2.0, vehicle.speed_mps(), 0.15);
}

TEST(LongitudinalVehicle, FullBrakeStopsTheCarAndHoldsIt) {
  vehicle.set_speed(15.0);
  int steps = 0;
  while (vehicle.speed_mps() > 1e-3 && steps < 10000) {
    vehicle.advance(0.0, 1.0, 0.001);
    CHECK(vehicle.acceleration_mps2() <= 1e-9);
    ++steps;
  }
  DOUBLES_EQUAL(15.0 / 9.4, steps * 0.001, 0.3);
  const double stopped_at = vehicle.distance_m();
  for (int i = 0; i < 2000; ++i) vehicle.advance(0.0, 1.0, 0.001);
  DOUBLES_EQUAL(0.0, vehicle.speed_mps(), 1e-4);
  DOUBLES_EQUAL(stopped_at, vehicle.distance_m(), 1e-3);
}

TEST(LongitudinalVehicle, WorkOfEveryForceAddsUpInEveryStep) {
  double worst = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double torque = i < 3000 ? 218.0 : i < 4000 ? -60.0 : 0.0;
    const double brake = i < 4000 ? 0.0 : 0.7;
    const VehicleEnergy e = vehicle.advance(torque, brake, 0.001);
    const double sum = e.kinetic_j + e.aero_j + e.rolling_j + e.slip_j + e.front_brake_j + e.rear_brake_j;
    worst = std::max(worst, std::abs(e.driveline_in_j - sum));
    CHECK(e.slip_j >= -1e-9);
    CHECK(e.front_brake_j >= 0.0);
  }
  DOUBLES_EQUAL(0.0, worst, 1e-9);
}

TEST(LongitudinalVehicle, ARollingCarLosesSpeedToDragAndRollingResistanceAlone) {
  vehicle.set_speed(20.0);
  vehicle.advance(0.0, 0.0, 0.001);
  // At the first step the wheels still turn at their old speed: only the mass slows down.
  DOUBLES_EQUAL(-(0.5 * 0.372 * 1.225 * 400.0 + 0.01 * 315.0 * 9.81) / 315.0, vehicle.acceleration_mps2(), 1e-9);
}
