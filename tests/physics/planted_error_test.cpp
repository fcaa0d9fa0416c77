// SPDX-License-Identifier: Apache-2.0
// Negative control of the energy ledger: one percent wrong in any single term must open it.
#include <cmath>

#include "fixtures.hpp"
#include "variants.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(PlantedError) {
  Drive drive{{"all losses", cornering_vtm16e(), false}};

  static VehicleParameters cornering_vtm16e() {
    VehicleParameters car = lossy_vtm16e();
    car.tyres.cornering_stiffness_per_rad = 20.0;
    return car;
  }

  void setup() override {
    drive.switch_on();
    drive.car.vehicle().set_road({.lateral_mps2 = 6.0, .longitudinal_share = 0.9, .grade = 0.03, .head_wind_mps = 4.0});
    drive.run(2.0, 500.0, 0.0);
    drive.run(0.6, 0.0, 0.4);
  }
};

TEST(PlantedError, EveryTermOfTheDriveIsThere) {
  for (std::size_t i = 0; i < kEnergyTerms; ++i) {
    const auto term = static_cast<EnergyTerm>(i);
    CHECK_TEXT(std::abs(drive.car.ledger()[term]) > 0.01, energy_term_name(term));
  }
}

TEST(PlantedError, OnePercentInAnyTermOpensTheLedgerAThousandTimesBeyondItsClosure) {
  const double closure = std::abs(drive.car.ledger().residual_j());
  for (std::size_t i = 0; i < kEnergyTerms; ++i) {
    const auto term = static_cast<EnergyTerm>(i);
    EnergyLedger wrong = drive.car.ledger();
    wrong.add(term, 0.01 * wrong[term]);
    CHECK_TEXT(std::abs(wrong.residual_j()) > 1000.0 * closure, energy_term_name(term));
  }
}
