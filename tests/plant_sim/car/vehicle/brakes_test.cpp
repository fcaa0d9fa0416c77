// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/brakes.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Brakes) {
  BrakeSection brakes = vtm16e().brakes;
};

TEST(Brakes, FullPedalHolds652NewtonMetresOverBothAxles) {
  const BrakeTorques full = brake_torques(brakes, 1.0);
  DOUBLES_EQUAL(2.0 * 5000.0 * 0.55 * 0.081, full.front_nm, 1e-9);
  DOUBLES_EQUAL(2.0 * 4100.0 * 0.45 * 0.056, full.rear_nm, 1e-9);
  DOUBLES_EQUAL(652.0, full.front_nm + full.rear_nm, 0.5);
}

TEST(Brakes, TorqueIsProportionalToPedalAndForceScale) {
  const BrakeTorques full = brake_torques(brakes, 1.0);
  DOUBLES_EQUAL(0.3 * full.front_nm, brake_torques(brakes, 0.3).front_nm, 1e-9);
  brakes.force_scale = 1.5;
  DOUBLES_EQUAL(1.5 * full.rear_nm, brake_torques(brakes, 1.0).rear_nm, 1e-9);
  DOUBLES_EQUAL(0.0, brake_torques(brakes, 0.0).front_nm, 0.0);
}

TEST(Brakes, WithoutCoolingARotorKeepsHalfOfItsAxlesHeat) {
  brakes.convection_w_per_m2_k = 0.0;
  BrakeRotors rotors(brakes, 26.85);
  for (int i = 0; i < 100; ++i) rotors.advance(200.0, 90.0, 0.01, 26.85);
  DOUBLES_EQUAL(0.5 * 20000.0, (rotors.front_c() - 26.85) * 0.346 * 507.0, 1e-6);
  DOUBLES_EQUAL(0.5 * 9000.0, (rotors.rear_c() - 26.85) * 0.217 * 507.0, 1e-6);
}

TEST(Brakes, UnderSteadyHeatARotorSettlesWhereCoolingBalancesIt) {
  BrakeRotors rotors(brakes, 26.85);
  for (int i = 0; i < 20000; ++i) rotors.advance(2000.0 * 0.01, 800.0 * 0.01, 0.01, 26.85);
  DOUBLES_EQUAL(26.85 + 1000.0 / (80.0 * 0.2), rotors.front_c(), 1e-3);
  DOUBLES_EQUAL(26.85 + 400.0 / (80.0 * 0.2), rotors.rear_c(), 1e-3);
}
