// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_config.hpp"

#include "core/parameter_file.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(FirmwareConfig) {
  VehicleParameters car = load_vehicle(DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data"), "vtm16e").parameters;

  std::string bms_complaint() {
    return complaint([&] { (void)bms_config(car); });
  }
};

TEST(FirmwareConfig, BmsFollowsThePackAndItsCell) {
  const bms::Config config = bms_config(car);
  LONGS_EQUAL(24, config.cells_in_series);
  LONGS_EQUAL(55'200, config.capacity_mah);
  LONGS_EQUAL(25'000, config.cell_voltage_min.raw());
  LONGS_EQUAL(42'000, config.cell_voltage_max.raw());
  LONGS_EQUAL(600'000, config.discharge_current_max.raw());
}

TEST(FirmwareConfig, CellsInParallelShareCapacityAndResistance) {
  const bms::Config one = bms_config(car);
  car.battery.cells_in_parallel = 2;
  const bms::Config two = bms_config(car);
  LONGS_EQUAL(2 * one.capacity_mah, two.capacity_mah);
  LONGS_EQUAL(one.resistance.resistance[10].raw() / 2, two.resistance.resistance[10].raw());
}

TEST(FirmwareConfig, ResistanceOfTheLimitIsTheSumOfTheCellsThree) {
  car.cell.r0_ohm.value.assign(car.cell.soc_breakpoints.size(), 0.0013);
  car.cell.branches[0].r_ohm.value.assign(car.cell.soc_breakpoints.size(), 0.0004);
  car.cell.branches[1].r_ohm.value.assign(car.cell.soc_breakpoints.size(), 0.0008);
  LONGS_EQUAL(2500, bms_config(car).resistance.resistance[10].raw());
}

TEST(FirmwareConfig, WhatAnExplanationAddsToTheCellIsInTheBmsTables) {
  const bms::Config given = bms_config(car);
  car.cell.effects.series_ohm = 0.0003;
  car.cell.effects.polarization_ohm = 0.0002;
  car.cell.effects.ocv_change_v = {0.01, 0.01};
  car.cell.effects.low_end_change = 1.0;
  const bms::Config extended = bms_config(car);
  LONGS_EQUAL(given.resistance.resistance[10].raw() + 500, extended.resistance.resistance[10].raw());
  LONGS_EQUAL(2 * given.resistance.resistance[0].raw() + 500, extended.resistance.resistance[0].raw());
  LONGS_EQUAL(given.ocv.voltage[0].raw() + 100, extended.ocv.voltage[0].raw());
}

TEST(FirmwareConfig, TemperatureCoefficientIsRelativeToTheResistanceAtTheReference) {
  car.cell.temperature_breakpoints_c = {0.0, car.cell.reference_temperature_c, 60.0};
  car.cell.r0_ohm.per_kelvin = -0.015;
  for (CellBranch& branch : car.cell.branches) branch.r_ohm.per_kelvin = -0.015;
  LONGS_EQUAL(-15'000, bms_config(car).resistance.ppm_per_kelvin);
}

TEST(FirmwareConfig, BmsMayHaveItsOwnIdeaOfCapacityAndResistance) {
  car.bms.capacity_ah = 40.0;
  car.bms.resistance_ohm = 0.003;
  LONGS_EQUAL(40'000, bms_config(car).capacity_mah);
  LONGS_EQUAL(3000, bms_config(car).resistance.resistance[0].raw());
}

TEST(FirmwareConfig, OcvTableMeetsTheCellsCurveAtBothEnds) {
  const bms::Config config = bms_config(car);
  LONGS_EQUAL(30'000, config.ocv.voltage[0].raw());                      // 3.00 V, constant term of the polynomial
  LONGS_EQUAL(41'700, config.ocv.voltage[config.ocv.count - 1].raw());   // sum of its coefficients
}

TEST(FirmwareConfig, TooFewThermistorsAreRefusedByName) {
  car.sensors.temperature_count = 5;  // 24 cells: 20 % are 4.8
  STRCMP_EQUAL("no error", bms_complaint().c_str());
  car.sensors.temperature_count = 4;
  STRCMP_CONTAINS("sensors.temperature_count", bms_complaint().c_str());
}

TEST(FirmwareConfig, TripTemperatureAboveTheRuleIsRefused) {
  car.bms.temperature_max_c = 60.1;
  STRCMP_CONTAINS("60", bms_complaint().c_str());
}

TEST(FirmwareConfig, PackWithoutDischargeCurrentIsRefused) {
  car.bms.discharge_current_max_a = 0.0;
  CHECK(bms_complaint() != "no error");
}

TEST(FirmwareConfig, MasterFollowsInverterAndMotor) {
  const master::Config config = master_config(car);
  LONGS_EQUAL(550'000, config.phase_current_max.raw());
  LONGS_EQUAL(150'000, config.motor_constant_unm_per_a);
}

TEST(FirmwareConfig, PedalSensorsAreTheMastersChannelsInVolts) {
  master::Config config = master_config(car);
  config.apps2.full = Potential::from_raw(22'001);
  const PedalSensors sensors = pedal_sensors(config);
  DOUBLES_EQUAL(0.5, sensors.apps1.released_v, 0.0);
  DOUBLES_EQUAL(4.5, sensors.apps1.full_v, 0.0);
  DOUBLES_EQUAL(0.25, sensors.apps2.released_v, 0.0);
  DOUBLES_EQUAL(2.2001, sensors.apps2.full_v, 0.0);
}

TEST(FirmwareConfig, InverterBeyondTheCommandsRangeIsRefusedByName) {
  car.inverter.current_max_a = 551.0;
  STRCMP_CONTAINS("inverter.current_max_a", complaint([&] { (void)master_config(car); }).c_str());
}
