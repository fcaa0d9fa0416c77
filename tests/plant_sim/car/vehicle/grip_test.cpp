// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/grip.hpp"

#include <cmath>

#include "car/vehicle/longitudinal.hpp"
#include "car/vehicle/tyre.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Grip) { VehicleParameters car = vtm16e(); };

TEST(Grip, PeakFrictionIsTheCrestOfTheSlipCurve) {
  for (const double c : {0.7, 1.0, 1.5, 2.5}) {
    for (const double e : {-3.0, 0.0, 0.9, 1.0}) {
      car.tyres.pacejka_c = c;
      car.tyres.pacejka_e = e;
      double crest = 0.0;
      for (double slip = 0.0; slip < 1e4; slip = slip * 1.01 + 1e-3) {
        crest = std::max(crest, tyre_force(car.tyres, slip, 1.0).force_n);
      }
      DOUBLES_EQUAL(crest, peak_friction(car.tyres), 0.01 * crest);
    }
  }
}

TEST(Grip, DriveGripIsTheForceAtWhichTheLoadedRearAxleSlides) {
  for (const double share : {1.0, 0.5, 0.1}) {
    const double resistance = 120.0, force = drive_grip(car, 15.0, share, resistance);
    const double acceleration = (force - resistance) / total_mass(car);
    DOUBLES_EQUAL(share * peak_friction(car.tyres) * axle_loads(car, acceleration, 15.0).rear_n, force, 1e-6);
  }
}

TEST(Grip, AtTheLockingPedalOneAxleIsAtItsGripAndNoneBeyond) {
  for (const double scale : {1.0, 3.0}) {
    for (const double share : {1.0, 0.6, 0.2}) {
      car.brakes.force_scale = scale;
      const double resistance = 80.0, r = car.tyres.radius_m;
      const double pedal = locking_pedal(car, 12.0, share, resistance, r);
      const BrakeTorques torques = brake_torques(car.brakes, pedal);
      const double front = torques.front_nm / r, rear = torques.rear_nm / r;
      const AxleLoads loads = axle_loads(car, -(front + rear + resistance) / total_mass(car), 12.0);
      const double friction = share * peak_friction(car.tyres);
      const double use = std::max(front / (friction * loads.front_n), rear / (friction * loads.rear_n));
      CHECK(use < 1.0 + 1e-9);
      CHECK(pedal == 1.0 || use > 1.0 - 1e-9);
    }
  }
}

TEST(Grip, BothAxlesPushAndBrakeWithWhatCorneringLeaves) {
  car.brakes.force_scale = 3.0;
  const double resistance = 82.0, mass = total_mass(car);
  for (const double share : {1.0, 0.5, 0.1}) {
    LongitudinalVehicle driven(car), braked(car);
    for (LongitudinalVehicle* vehicle : {&driven, &braked}) {
      vehicle->set_speed(15.0);
      vehicle->set_road({.longitudinal_share = share});
    }
    const double most_n = drive_grip(car, 15.0, share, resistance);
    double push = 0.0, drag = 0.0;
    for (int i = 0; i < 1500; ++i) {
      driven.advance(1.05 * most_n * car.tyres.radius_m, 0.0, 0.001);
      braked.advance(0.0, 1.0, 0.001);
      push = std::max(push, driven.acceleration_mps2());
      if (i == 50) drag = -braked.acceleration_mps2();  // all wheels lock by then
    }
    DOUBLES_EQUAL(most_n, push * mass + resistance, 0.03 * most_n);
    const double locked = 0.77 * share * peak_friction(car.tyres) * 9.81;  // what the slip curve has left at -1
    DOUBLES_EQUAL(locked + resistance / mass, drag, 0.05 * drag);
  }
}

TEST(Grip, LessFrictionNeverHoldsMore) {
  double lateral = 1e9, drive = 1e9, pedal = 2.0;
  for (double d = 3.0; d > 0.1; d *= 0.9) {
    car.tyres.pacejka_d = d;
    CHECK(lateral_grip(car, 10.0) < lateral);
    CHECK(drive_grip(car, 10.0, 1.0, 0.0) <= drive);
    CHECK(locking_pedal(car, 10.0, 1.0, 0.0, 0.22) <= pedal);
    lateral = lateral_grip(car, 10.0);
    drive = drive_grip(car, 10.0, 1.0, 0.0);
    pedal = locking_pedal(car, 10.0, 1.0, 0.0, 0.22);
  }
}

TEST(Grip, ATallNarrowCarLiftsAWheelBeforeItSlides) {
  CHECK(lateral_lift(car, 10.0) > lateral_grip(car, 10.0));
  car.vehicle.cg_height_m = 0.8;
  CHECK(lateral_lift(car, 10.0) < lateral_grip(car, 10.0));
}
