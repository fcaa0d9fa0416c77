// SPDX-License-Identifier: Apache-2.0
// Directions: what falls, rises and heats, in every variant of the model.
#include "fixtures.hpp"
#include "variants.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Signs){};

TEST(Signs, DischargeLowersVoltageAndStateOfChargeAndHeatsInEveryVariant) {
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    const Pack& pack = drive.car.pack();
    const double rest = pack.voltage(), soc = pack.soc_mean(), cold = pack.temperature_max_c();
    drive.switch_on();
    drive.run(2.0, 450.0, 0.0);
    CHECK_TEXT(drive.car.pack_current_a() > 0.0, variant.name.c_str());
    CHECK_TEXT(pack.voltage() < rest, variant.name.c_str());
    CHECK_TEXT(pack.soc_mean() < soc, variant.name.c_str());
    CHECK_TEXT(pack.temperature_max_c() > cold, variant.name.c_str());
  }
}

TEST(Signs, RegenerationChargesInEveryVariantWithAPowertrain) {
  for (const Variant& variant : all_variants()) {
    if (variant.car.powertrain.kind == "none") continue;
    Drive drive(variant);
    drive.switch_on();
    drive.run(2.0, 450.0, 0.0);
    const double soc = drive.car.pack().soc_mean(), speed = drive.car.vehicle().speed_mps();
    drive.run(0.5, -200.0, 0.0);
    CHECK_TEXT(drive.car.pack_current_a() < 0.0, variant.name.c_str());
    CHECK_TEXT(drive.car.pack().soc_mean() > soc, variant.name.c_str());
    CHECK_TEXT(drive.car.vehicle().speed_mps() < speed, variant.name.c_str());
  }
}

TEST(Signs, EveryHeatAndLossIsPositiveInEveryVariant) {
  constexpr EnergyTerm kLosses[] = {EnergyTerm::kBatteryR0Heat, EnergyTerm::kBatteryRcHeat, EnergyTerm::kContactorHeat,
                                    EnergyTerm::kBleedHeat, EnergyTerm::kLowVoltage, EnergyTerm::kInverterHeat,
                                    EnergyTerm::kMotorHeat, EnergyTerm::kDrivelineHeat, EnergyTerm::kAero,
                                    EnergyTerm::kRolling, EnergyTerm::kTyreSlip, EnergyTerm::kBrakeFront,
                                    EnergyTerm::kBrakeRear};
  for (const Variant& variant : all_variants()) {
    Drive drive(variant);
    drive.switch_on();
    for (const auto& [current, brake] : {std::pair{450.0, 0.0}, {0.0, 0.0}, {-150.0, 0.0}, {0.0, 0.6}}) {
      const EnergyLedger before = drive.car.ledger();
      drive.run(0.5, current, brake);
      const EnergyLedger phase = drive.car.ledger().since(before);
      for (const EnergyTerm term : kLosses) CHECK_TEXT(phase[term] >= -1e-9, variant.name.c_str());
    }
  }
}

TEST(Signs, ALossyPartCostsSpeedOrEnergyForTheSameCommand) {
  const auto reach = [](const VehicleParameters& car) {
    Drive drive({"", car, true});
    drive.switch_on();
    drive.run(2.0, 450.0, 0.0);
    return std::pair{drive.car.vehicle().speed_mps(), drive.car.energy_out_j()};
  };
  const auto [speed, energy] = reach(vtm16e());
  VehicleParameters car = vtm16e();
  car.motor.efficiency = 0.9;
  CHECK(reach(car).first < speed);
  car = vtm16e();
  car.powertrain.driveline_efficiency = 0.9;
  CHECK(reach(car).first < speed);
  car = vtm16e();
  car.inverter.efficiency = 0.95;
  CHECK(reach(car).second > energy);
  car = vtm16e();
  car.motor.winding_loss = true;
  CHECK(reach(car).second > energy);
}

TEST(Signs, AColdOrAgedPackSagsMore) {
  const auto lowest = [](const VehicleParameters& car) {
    Drive drive({"", car, true});
    drive.switch_on();
    drive.run(2.0, 450.0, 0.0);
    return drive.car.pack().voltage();
  };
  VehicleParameters cold = vtm16e(), aged = vtm16e();
  cold.battery.initial_temperature_c = 22.0;
  for (double& r : aged.cell.r0_ohm.value) r *= 1.5;
  CHECK(lowest(cold) < lowest(vtm16e()));
  CHECK(lowest(aged) < lowest(vtm16e()));
}
