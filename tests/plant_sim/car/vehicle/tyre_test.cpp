// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/tyre.hpp"

#include <algorithm>
#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Tyre) {
  TyreSection tyre = vtm16e().tyres;
};

TEST(Tyre, PeakForceIsTheNormalForceTimesItsFriction) {
  double peak = 0.0;
  for (double slip = 0.0; slip < 1.0; slip += 1e-4) peak = std::max(peak, tyre_force(tyre, slip, 1600.0).force_n);
  DOUBLES_EQUAL(1.5 * 1600.0, peak, 1e-3);
}

TEST(Tyre, ForceIsOddInSlipAndProportionalToLoad) {
  for (const double slip : {0.01, 0.1, 0.4, 2.0}) {
    DOUBLES_EQUAL(-tyre_force(tyre, slip, 900.0).force_n, tyre_force(tyre, -slip, 900.0).force_n, 1e-9);
    DOUBLES_EQUAL(2.0 * tyre_force(tyre, slip, 900.0).force_n, tyre_force(tyre, slip, 1800.0).force_n, 1e-9);
  }
  DOUBLES_EQUAL(0.0, tyre_force(tyre, 0.0, 900.0).force_n, 0.0);
}

TEST(Tyre, SlopeIsTheDerivativeOfTheForce) {
  for (const double slip : {-0.6, -0.12, -0.01, 0.0, 0.03, 0.15, 0.5}) {
    const double above = tyre_force(tyre, slip + 1e-6, 1600.0).force_n;
    const double below = tyre_force(tyre, slip - 1e-6, 1600.0).force_n;
    DOUBLES_EQUAL((above - below) / 2e-6, tyre_force(tyre, slip, 1600.0).slope_n, 1e-2);
  }
  DOUBLES_EQUAL(1600.0 * 1.5 * 1.5221 * 11.0947, tyre_force(tyre, 0.0, 1600.0).slope_n, 1e-6);
}

TEST(Tyre, AStandingWheelUnderFullTorqueApproachesItsSlipWithoutOscillation) {
  const AxleInput in{0.0, 1607.0, 220.0, 0.0, 0.632};  // full torque of the motor, within the grip of 535 Nm
  double omega = 0.0, rise_before = 1e9;
  for (int i = 0; i < 200; ++i) {
    const double next = axle_step(tyre, in, omega, 0.001).omega_rad_s;
    const double rise = next - omega;
    CHECK(rise >= -1e-12);
    CHECK(rise <= rise_before + 1e-12);
    rise_before = rise;
    omega = next;
  }
  const double slip = omega * tyre.radius_m / tyre.slip_speed_floor_mps;
  DOUBLES_EQUAL(220.0 / tyre.radius_m, tyre_force(tyre, slip, 1607.0).force_n, 1e-3);
}

TEST(Tyre, AFreeWheelsSpeedErrorShrinksWithoutChangingSignFromAnySlip) {
  for (const double inertia : {0.2, 0.632}) {
    for (const double speed : {0.0, 0.3, 1.0, 5.0}) {
      for (const double start : {-2.0, -0.3, -0.08, -0.01, 0.01, 0.08, 0.3, 2.0}) {
        const AxleInput in{speed, 1607.0, 0.0, 0.0, inertia};
        double omega = (speed + start) / tyre.radius_m, error = std::abs(start);
        for (int i = 0; i < 100; ++i) {
          omega = axle_step(tyre, in, omega, 0.001).omega_rad_s;
          const double now = (omega * tyre.radius_m - speed) * (start > 0.0 ? 1.0 : -1.0);
          CHECK(now <= error && now >= -1e-12);
          error = now;
        }
        CHECK(error < 1e-6);
      }
    }
  }
}

TEST(Tyre, BrakeHoldsAStandingWheelAgainstATorqueBelowItsOwn) {
  const AxleStep held = axle_step(tyre, {0.0, 1607.0, 200.0, 206.0, 0.632}, 0.0, 0.001);
  DOUBLES_EQUAL(0.0, held.omega_rad_s, 0.0);
  DOUBLES_EQUAL(200.0, held.brake_torque_nm, 1e-9);
  DOUBLES_EQUAL(0.0, held.force_n, 1e-9);
  const AxleStep turns = axle_step(tyre, {0.0, 1607.0, 210.0, 206.0, 0.632}, 0.0, 0.001);
  CHECK(turns.omega_rad_s > 0.0);
  DOUBLES_EQUAL(206.0, turns.brake_torque_nm, 1e-9);
}

TEST(Tyre, ALockedWheelSlidesWithTheForceOfFullSlipAndStaysLocked) {
  const AxleStep locked = axle_step(tyre, {10.0, 800.0, 0.0, 900.0, 0.632}, 0.0, 0.001);
  DOUBLES_EQUAL(0.0, locked.omega_rad_s, 0.0);
  DOUBLES_EQUAL(tyre_force(tyre, -1.0, 800.0).force_n, locked.force_n, 1e-9);
  CHECK(locked.force_n < 0.0);
}

TEST(Tyre, BrakeNeverTurnsAWheelBackwards) {
  double omega = 5.0 / tyre.radius_m;
  for (int i = 0; i < 500; ++i) {
    omega = axle_step(tyre, {5.0, 300.0, 0.0, 600.0, 0.2}, omega, 0.001).omega_rad_s;
    CHECK(omega >= 0.0);
  }
  DOUBLES_EQUAL(0.0, omega, 0.0);
}
