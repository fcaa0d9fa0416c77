// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_notes.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(RunNotes) {
  RunDescription run;
  VehicleParameters car = vtm16e();
  EnduranceResult result;

  std::string said() {
    std::string out;
    for (const std::string& note : run_notes(run, car, result)) out += note + '\n';
    return out;
  }
};

TEST(RunNotes, ARunWithinItsTablesHasNone) {
  result.max_battery_temp_c = 39.9;
  result.max_battery_current_a = 399.0;
  run.settings = {"vehicle.mass_kg=230"};
  STRCMP_EQUAL("", said().c_str());
}

TEST(RunNotes, AWeighedCarSaysThatAnotherPackWeighsNothing) {
  for (const char* setting : {"battery.cell=x", "battery.cells_in_series=20", "battery.cells_in_parallel=2"}) {
    run.settings = {setting};
    STRCMP_CONTAINS("weighs 243 kg with any pack", said().c_str());
  }
  car.vehicle.mass_kg = 0.0;
  car.vehicle.mass_without_pack_kg = 190.0;
  STRCMP_EQUAL("", said().c_str());
  run.settings = {"battery.capacity_ah=60"};
  STRCMP_CONTAINS("changes the charge alone", said().c_str());
}

TEST(RunNotes, AMotorOfItsOwnRotorSaysThatTheOldOneMayCountTwice) {
  run.settings = {"motor.model=emrax_228_hv"};
  STRCMP_EQUAL("", said().c_str());  // no rotor is stated
  car.motor.rotor_inertia_kg_m2 = 0.04;
  STRCMP_CONTAINS("adds 0.28 kg m2 at the wheels to the car's 0.632 kg m2", said().c_str());
  run.settings.emplace_back("powertrain.driveline_inertia_kg_m2=0.3");
  STRCMP_EQUAL("", said().c_str());
}

TEST(RunNotes, ALinkThatFellBelowTheInverterIsSaidWithItsTimes) {
  result.beyond.link_falls = 1;
  STRCMP_CONTAINS("fell below inverter.dc_voltage_min_v = ", said().c_str());
  STRCMP_CONTAINS(" V once, where the inverter switches off", said().c_str());
  result.beyond.link_falls = 41;
  STRCMP_CONTAINS(" V 41 times, ", said().c_str());
}

TEST(RunNotes, OneTableForEveryCurrentIsLeftByNone) {
  car.cell.current_breakpoints_a = {0.0};
  result.max_battery_current_a = 300.0;
  STRCMP_EQUAL("", said().c_str());
}

TEST(RunNotes, TablesThatWereLeftAreSaidWithTheirEnds) {
  result.max_battery_temp_c = 40.1;
  STRCMP_EQUAL("cells reached 40.1 degC, the tables of aesc_e5_2p end at 40 degC: their last values were taken\n",
               said().c_str());
  car.cell.kinetic_law = true;
  STRCMP_EQUAL("", said().c_str());
  result.max_battery_temp_c = 50.1;
  STRCMP_CONTAINS("end at 50 degC", said().c_str());
  car.cell.kinetic_law = false;
  result.max_battery_temp_c = 39.0;
  car.battery.initial_temperature_c = 5.0;
  STRCMP_CONTAINS("cells began at 5.0 degC, the tables of aesc_e5_2p end at 22 degC", said().c_str());
  car.battery.initial_temperature_c = 25.0;
  result.max_battery_current_a = 410.0;
  STRCMP_CONTAINS("a cell gave 410.0 A", said().c_str());
  car.battery.cells_in_parallel = 2;
  STRCMP_EQUAL("", said().c_str());
}
