// SPDX-License-Identifier: Apache-2.0
#include "car/energy_ledger.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(EnergyLedger) {
  EnergyLedger ledger;
};

TEST(EnergyLedger, ClosesWhenTheTermsSumToTheSource) {
  ledger.add(EnergyTerm::kBatteryChemical, 1000.0);
  ledger.add(EnergyTerm::kKinetic, 700.0);
  ledger.add(EnergyTerm::kAero, 300.0);
  DOUBLES_EQUAL(0.0, ledger.residual_j(), 0.0);
  DOUBLES_EQUAL(0.0, ledger.error_pct(), 0.0);
}

TEST(EnergyLedger, EveryTermEntersTheResidual) {
  for (std::size_t i = 0; i < kEnergyTerms; ++i) {
    EnergyLedger one;
    one.add(static_cast<EnergyTerm>(i), 5.0);
    DOUBLES_EQUAL(i == 0 ? 5.0 : -5.0, one.residual_j(), 0.0);
  }
}

TEST(EnergyLedger, ErrorIsTheResidualInPercentOfTheSource) {
  ledger.add(EnergyTerm::kBatteryChemical, 1000.0);
  ledger.add(EnergyTerm::kAero, 990.0);
  DOUBLES_EQUAL(1.0, ledger.error_pct(), 1e-12);
}

TEST(EnergyLedger, ALapsBalanceIsTheDifferenceOfTwo) {
  ledger.add(EnergyTerm::kBatteryChemical, 100.0);
  const EnergyLedger start = ledger;
  ledger.add(EnergyTerm::kBatteryChemical, 30.0);
  ledger.add(EnergyTerm::kRolling, 30.0);
  DOUBLES_EQUAL(30.0, ledger.since(start)[EnergyTerm::kBatteryChemical], 0.0);
  DOUBLES_EQUAL(0.0, ledger.since(start).error_pct(), 0.0);
}
