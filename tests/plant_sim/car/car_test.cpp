// SPDX-License-Identifier: Apache-2.0
#include "car/car.hpp"

#include <cmath>
#include <memory>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Car) {
  VehicleParameters parameters = vtm16e();
  std::unique_ptr<Car> car;

  void build() { car = std::make_unique<Car>(parameters, true, 0.001); }
  void drive(double seconds, double phase_current_a, double brake = 0.0) {
    for (int period = 0; period < std::lround(seconds * 100.0); ++period) {
      car->inverter.command(phase_current_a, true);
      for (int i = 0; i < 10; ++i) car->step(brake);
      car->renew(0.01);
    }
  }
  void switch_on() {
    build();
    car->contactors.air_minus.command(true);
    car->contactors.precharge.command(true);
    drive(0.6, 0.0);
    car->contactors.air_plus.command(true);
    drive(0.1, 0.0);
  }
};

TEST(Car, DoesNotMoveWithOpenContactors) {
  build();
  drive(1.0, 550.0);
  DOUBLES_EQUAL(0.0, car->vehicle().speed_mps(), 0.0);
  DOUBLES_EQUAL(0.0, car->pack_current_a(), 0.0);
  DOUBLES_EQUAL(0.0, car->phase_current_a(), 0.0);
}

TEST(Car, PrechargeRaisesTheDcLinkWithoutASurge) {
  build();
  car->contactors.air_minus.command(true);
  car->contactors.precharge.command(true);
  double most = 0.0;
  for (int i = 0; i < 60; ++i) {
    drive(0.01, 0.0);
    most = std::fmax(most, car->pack_current_a());
  }
  CHECK(most < 1.01);
  CHECK(car->dc_link_voltage() > 0.95 * car->pack().voltage());
}

TEST(Car, ClosingOnAnEmptyDcLinkIsASurgeOfHundredsOfAmperes) {
  build();
  car->contactors.air_minus.command(true);
  car->contactors.air_plus.command(true);
  double most = 0.0;
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 10; ++k) {
      car->step(0.0);
      most = std::fmax(most, car->pack_current_a());
    }
    car->renew(0.01);
  }
  CHECK(most > 50.0);
}

TEST(Car, LowVoltageLoadStartsBehindTheMainContactors) {
  build();
  car->contactors.air_minus.command(true);
  car->contactors.precharge.command(true);
  drive(0.6, 0.0);
  DOUBLES_EQUAL(0.0, car->ledger()[EnergyTerm::kLowVoltage], 0.0);
  car->contactors.air_plus.command(true);
  drive(1.0, 0.0);
  const double load_w = car->parameters().low_voltage.power_w;
  DOUBLES_EQUAL(load_w * 0.97, car->ledger()[EnergyTerm::kLowVoltage], load_w * 0.011);
}

TEST(Car, PhaseCurrentDrivesAndNegativeCurrentChargesThePack) {
  switch_on();
  drive(3.0, 400.0);
  CHECK(car->vehicle().speed_mps() > 6.0);
  CHECK(car->pack_current_a() > 50.0);
  const double speed = car->vehicle().speed_mps(), soc = car->pack().soc_mean();
  drive(0.5, -200.0);
  CHECK(car->pack_current_a() < 0.0);
  CHECK(car->vehicle().speed_mps() < speed);
  CHECK(car->pack().soc_mean() > soc);
}

TEST(Car, OpeningTheContactorsUnderLoadEndsTheDrive) {
  switch_on();
  drive(2.0, 400.0);
  car->contactors.air_plus.command(false);
  car->contactors.air_minus.command(false);
  car->contactors.precharge.command(false);
  drive(0.2, 400.0);
  DOUBLES_EQUAL(0.0, car->pack_current_a(), 0.0);
  DOUBLES_EQUAL(0.0, car->phase_current_a(), 0.0);  // the DC link is empty: under-voltage
}

TEST(Car, EnergyOutIsVoltageTimesCurrentAtTheTerminals) {
  switch_on();
  drive(3.0, 400.0);
  const EnergyLedger& l = car->ledger();
  const double at_terminals = l[EnergyTerm::kBatteryChemical] - l[EnergyTerm::kBatteryR0Heat] -
                              l[EnergyTerm::kBatteryRcHeat] - l[EnergyTerm::kBatteryRcStored];
  DOUBLES_EQUAL(at_terminals, car->energy_out_j(), 1e-9 * at_terminals);
}

TEST(Car, WithoutPowertrainItCoastsWhateverIsCommanded) {
  parameters.powertrain.kind = "none";
  switch_on();
  car->vehicle().set_speed(15.0);
  drive(2.0, 550.0);
  CHECK(car->vehicle().speed_mps() < 15.0);
  DOUBLES_EQUAL(0.0, car->phase_current_a(), 0.0);
  DOUBLES_EQUAL(0.0, car->ledger()[EnergyTerm::kMotorHeat], 0.0);
}

TEST(Car, APackThatCannotDeliverIsFlagged) {
  parameters.cell.r0_ohm.value.assign(parameters.cell.soc_breakpoints.size(), 0.02);
  switch_on();
  CHECK_FALSE(car->voltage_collapsed());
  drive(10.0, 550.0);
  CHECK(car->voltage_collapsed());
}

TEST(Car, WhatAChargerGivesIsWhatTheLedgerMisses) {
  parameters.battery.initial_soc = 0.5;
  Car on_charger(parameters, true, 0.01);
  on_charger.charger.plugged = true;
  on_charger.contactors.air_minus.command(true);
  on_charger.contactors.precharge.command(true);
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      on_charger.charger.command(110.0, 20.0, on_charger.contactors.main_closed());
      on_charger.step(0.0);
      on_charger.renew(0.01);
    }
  };
  run(200);
  on_charger.contactors.air_plus.command(true);
  run(6'000);
  DOUBLES_EQUAL(-20.0, on_charger.pack_current_a(), 0.1);
  CHECK(on_charger.charger_energy_j() > 90'000.0);
  DOUBLES_EQUAL(on_charger.charger_energy_j(), -on_charger.ledger().residual_j(), 1e-3 * on_charger.charger_energy_j());
  DOUBLES_EQUAL(0.0, on_charger.ledger()[EnergyTerm::kLowVoltage], 0.0);  // the charger's side feeds it
}
