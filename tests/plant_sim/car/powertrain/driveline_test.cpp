// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/driveline.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Driveline) {
  PowertrainSection section = lossy_vtm16e().powertrain;
};

TEST(Driveline, LosesADrivingTorqueAndAddsToABrakingOne) {
  DOUBLES_EQUAL(80.0 * 32.0 / 12.0 * 0.9, wheel_torque(section, 80.0, true), 1e-9);
  DOUBLES_EQUAL(-80.0 * 32.0 / 12.0 / 0.9, wheel_torque(section, -80.0, false), 1e-9);
}

TEST(Driveline, LossIsPowerInLessPowerOutInBothDirections) {
  for (const bool driving : {true, false}) {
    const double shaft_nm = driving ? 50.0 : -50.0, omega = 200.0;
    const double wheel_w = wheel_torque(section, shaft_nm, driving) * omega / section.final_drive;
    DOUBLES_EQUAL(shaft_nm * omega - wheel_w, driveline_loss(section, shaft_nm * omega, driving), 1e-9);
    CHECK(driveline_loss(section, shaft_nm * omega, driving) > 0.0);
  }
}
