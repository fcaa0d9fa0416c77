// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/motor.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Motor) {
  MotorSection motor = lossy_vtm16e().motor;

  double stored_j(const MotorThermal& t) const {
    return (t.copper_c() - 26.85) * motor.copper_mass_kg * motor.copper_heat_capacity_j_per_kg_k +
           (t.steel_c() - 26.85) * motor.steel_mass_kg * motor.steel_heat_capacity_j_per_kg_k +
           (t.aluminium_c() - 26.85) * motor.aluminium_mass_kg * motor.aluminium_heat_capacity_j_per_kg_k;
  }
};

TEST(Motor, TorqueIsConstantTimesCurrentLessItsLoss) {
  DOUBLES_EQUAL(0.15 * 550.0 * 0.9, motor_torque(motor, 550.0, 300.0), 1e-9);
  DOUBLES_EQUAL(0.15 * -100.0 / 0.9, motor_torque(motor, -100.0, 300.0), 1e-9);
  DOUBLES_EQUAL(0.15 * 550.0 * 0.9, motor_torque(motor, 550.0, 0.0), 1e-9);
}

TEST(Motor, ElectricalPowerIsShaftPowerPlusLossInBothDirections) {
  for (const bool winding : {false, true}) {
    motor.winding_loss = winding;
    for (const double current : {-300.0, 0.0, 40.0, 550.0}) {
      const double omega = 250.0;
      const double shaft = motor_torque(motor, current, omega) * omega;
      const double loss = motor_loss(motor, current, omega, current * omega >= 0.0);
      DOUBLES_EQUAL(motor_power(motor, current, omega), shaft + loss, 1e-9);
      CHECK(loss >= 0.0);
    }
  }
}

TEST(Motor, AStalledMotorTurnsCurrentIntoWindingHeatAlone) {
  DOUBLES_EQUAL(0.0063 * 550.0 * 550.0, motor_loss(motor, 550.0, 0.0, true), 1e-9);
  DOUBLES_EQUAL(0.0063 * 550.0 * 550.0, motor_power(motor, 550.0, 0.0), 1e-9);
}

TEST(Motor, WithoutCoolingTheChainKeepsEveryJoule) {
  motor.convection_w_per_m2_k = 0.0;
  MotorThermal thermal(motor, 26.85);
  for (int i = 0; i < 5000; ++i) thermal.advance(15.0, 0.01, 26.85);
  DOUBLES_EQUAL(75000.0, stored_j(thermal), 1e-6);
  CHECK(thermal.copper_c() > thermal.steel_c());
  CHECK(thermal.steel_c() > thermal.aluminium_c());
}

TEST(Motor, SteadyLossSettlesToTheSeriesOfItsThermalResistances) {
  MotorThermal thermal(motor, 26.85);
  for (int i = 0; i < 300000; ++i) thermal.advance(120.0 * 0.1, 0.1, 26.85);
  const double to_air = 1.0 / 6406.0 + 1.0 / (25.0 * 0.14);
  DOUBLES_EQUAL(26.85 + 120.0 * to_air, thermal.aluminium_c(), 1e-3);
  DOUBLES_EQUAL(26.85 + 120.0 * (to_air + 1.0 / 1176.0), thermal.steel_c(), 1e-3);
  DOUBLES_EQUAL(26.85 + 120.0 * (to_air + 1.0 / 1176.0 + 1.0 / 7.2), thermal.copper_c(), 1e-3);
}
