// SPDX-License-Identifier: Apache-2.0
// Charge and energy are conserved in every variant of the model.
#include <cmath>

#include "fixtures.hpp"
#include "variants.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Conservation){};

TEST(Conservation, ChargeThatLeftIsStateOfChargeTimesCapacityInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    const Pack& pack = drive.car.pack();
    std::vector<double> start;
    for (std::size_t i = 0; i < pack.cells(); ++i) start.push_back(pack.cell_soc(i));
    drive.switch_on();
    drive.mixed();
    CHECK_TEXT(pack.charge_out_ah() > 0.0, variant.name.c_str());
    for (std::size_t i = 0; i < pack.cells(); ++i) {
      const double counted = (start[i] - pack.cell_soc(i)) * pack.capacity_ah(i);
      DOUBLES_EQUAL_TEXT(pack.charge_out_ah(), counted, 1e-8 * pack.charge_out_ah(), variant.name.c_str());
    }
  }
}

TEST(Conservation, TheEnergyLedgerClosesInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    drive.mixed();
    CHECK_TEXT(drive.car.ledger()[EnergyTerm::kBatteryChemical] > 100.0, variant.name.c_str());
    CHECK_TEXT(drive.car.ledger().error_pct() < 1e-6, variant.name.c_str());
  }
}

TEST(Conservation, EveryPhaseOfADriveClosesOnItsOwn) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    EnergyLedger before = drive.car.ledger();
    for (const auto& [current, brake] : {std::pair{450.0, 0.0}, {0.0, 0.0}, {-150.0, 0.0}, {0.0, 0.6}, {300.0, 0.3}}) {
      drive.run(0.5, current, brake);
      const EnergyLedger phase = drive.car.ledger().since(before);
      DOUBLES_EQUAL_TEXT(0.0, phase.residual_j(), 1e-5, variant.name.c_str());
      before = drive.car.ledger();
    }
  }
}

TEST(Conservation, OpenCircuitEnergyLessHeatAndStorageIsTheTerminalEnergyInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    drive.mixed();
    const EnergyLedger& l = drive.car.ledger();
    const double at_terminals = l[EnergyTerm::kBatteryChemical] - l[EnergyTerm::kBatteryR0Heat] -
                                l[EnergyTerm::kBatteryRcHeat] - l[EnergyTerm::kBatteryRcStored];
    DOUBLES_EQUAL_TEXT(drive.car.energy_out_j(), at_terminals, 1e-9 * l[EnergyTerm::kBatteryChemical],
                       variant.name.c_str());
  }
}

TEST(Conservation, TheVoltageOfEveryStepIsTheOnePredictedBeforeItInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    for (int i = 0; i < 200; ++i) {
      drive.car.inverter.command(i < 100 ? 450.0 : -100.0, true);
      const PackThevenin source = drive.car.pack().thevenin();
      drive.car.step(0.0);
      DOUBLES_EQUAL_TEXT(source.voltage_v - source.resistance_ohm * drive.car.pack_current_a(),
                         drive.car.pack().voltage(), 1e-9, variant.name.c_str());
      if (i % 10 == 9) drive.car.renew(0.01);
    }
  }
}

TEST(Conservation, PackVoltageIsTheSumOfItsCellsInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    drive.mixed();
    double sum = 0.0;
    for (std::size_t i = 0; i < drive.car.pack().cells(); ++i) sum += drive.car.pack().cell_voltage(i);
    DOUBLES_EQUAL_TEXT(sum, drive.car.pack().voltage(), 1e-9, variant.name.c_str());
  }
}
