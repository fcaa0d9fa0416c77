// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_file.hpp"

#include "scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ParameterFile) {
  DataFolder data{VOLTLAP_SOURCE_DIR "/plant_sim/data"};
  Scratch scratch;

  VehicleParameters with(const std::vector<std::string>& settings, const std::string& vehicle = "vtm16e") {
    return load_vehicle(data, vehicle, settings).parameters;
  }
  std::string complaint_of(const std::vector<std::string>& settings, const std::string& vehicle = "vtm16e") {
    return complaint([&] { (void)with(settings, vehicle); });
  }
  std::string car_with(const std::string& lines) { return scratch.write("car.toml", "base = \"vtm16e\"\n" + lines); }
};

TEST(ParameterFile, EveryVehicleOfTheProjectLoads) {
  for (const std::string& name : data.names("vehicles")) STRCMP_EQUAL(name.c_str(), with({}, name).name.c_str());
}

TEST(ParameterFile, VehicleWithABaseInheritsAndOverrides) {
  const VehicleParameters car = with({}, "vtm17e"), base = with({});
  LONGS_EQUAL(22, car.battery.cells_in_series);
  DOUBLES_EQUAL(219.0, car.vehicle.mass_kg, 0.0);
  DOUBLES_EQUAL(base.vehicle.wheelbase_m, car.vehicle.wheelbase_m, 0.0);
}

TEST(ParameterFile, SettingBeatsVehicleAndVehicleBeatsCellFile) {
  const double of_cell_file = with({}).cell.capacity_ah;
  const std::string car = car_with("[battery]\ncapacity_ah = 40.0\n");
  CHECK(of_cell_file != 40.0);
  DOUBLES_EQUAL(40.0, with({}, car).cell.capacity_ah, 0.0);
  DOUBLES_EQUAL(30.0, with({"battery.capacity_ah=30"}, car).cell.capacity_ah, 0.0);
  DOUBLES_EQUAL(20.0, with({"cell.capacity_ah=20"}, car).cell.capacity_ah, 0.0);
  DOUBLES_EQUAL(20.0, with({"cell.capacity_ah=20"}, car).battery.capacity_ah, 0.0);
}

TEST(ParameterFile, EveryMotorAndEveryCellOfTheProjectLoads) {
  for (const std::string& name : data.names("motors")) {
    STRCMP_EQUAL(name.c_str(), with({"motor.model=" + name}).motor.model.c_str());
  }
  for (const std::string& name : data.names("cells")) {
    STRCMP_EQUAL(name.c_str(), load_cell(data, name, "test").name.c_str());
  }
}

TEST(ParameterFile, WhoChangesTheTyresRadiusMeansTheLapSolversToo) {
  DOUBLES_EQUAL(0.22, with({}).tyres.lap_radius_m, 0.0);
  DOUBLES_EQUAL(0.25, with({"tyres.radius_m=0.25"}).tyres.lap_radius_m, 0.0);
  DOUBLES_EQUAL(0.25, with({}, car_with("[tyres]\nradius_m = 0.25\n")).tyres.lap_radius_m, 0.0);
  // Given beside it, in any order, it stays.
  DOUBLES_EQUAL(0.24, with({"tyres.lap_radius_m=0.24", "tyres.radius_m=0.25"}).tyres.lap_radius_m, 0.0);
  DOUBLES_EQUAL(0.24, with({}, car_with("[tyres]\nradius_m = 0.25\nlap_radius_m = 0.24\n")).tyres.lap_radius_m, 0.0);
}

TEST(ParameterFile, NamedMotorReplacesTheMotorOfTheBaseAndTheCarsOwnNumbersOverrideIt) {
  const VehicleParameters base = with({});
  const std::string car = car_with("[motor]\nmodel = \"emrax_228_hv\"\nefficiency = 0.9\n");
  const MotorSection motor = with({}, car).motor;
  DOUBLES_EQUAL(1.1, motor.constant_nm_per_a, 0.0);
  DOUBLES_EQUAL(600.0, motor.curve_voltage_v, 0.0);
  DOUBLES_EQUAL(0.9, motor.efficiency, 0.0);
  CHECK(base.motor.curve_torque_nm != motor.curve_torque_nm);
}

TEST(ParameterFile, SettingOfAMotorReplacesAllOfTheCarsMotorButOtherSettings) {
  for (const bool model_first : {false, true}) {
    std::vector<std::string> settings = {"motor.efficiency=0.8", "motor.model=emrax_228_lv"};
    if (model_first) std::swap(settings[0], settings[1]);
    const MotorSection motor = with(settings, car_with("[motor]\nconstant_nm_per_a = 0.5\n")).motor;
    DOUBLES_EQUAL(0.27, motor.constant_nm_per_a, 0.0);
    DOUBLES_EQUAL(0.8, motor.efficiency, 0.0);
  }
}

TEST(ParameterFile, LastOfTwoSettingsOfAKeyHolds) {
  DOUBLES_EQUAL(250.0, with({"vehicle.mass_kg=240", "vehicle.mass_kg=250"}).vehicle.mass_kg, 0.0);
}

TEST(ParameterFile, SingleCellIsNumberedFromOne) {
  const VehicleParameters car = with({"battery.cells.3.capacity_scale=0.92"});
  LONGS_EQUAL(3, car.battery.cells.size());
  DOUBLES_EQUAL(0.92, car.battery.cells[2].capacity_scale, 0.0);
  DOUBLES_EQUAL(1.0, car.battery.cells[1].capacity_scale, 0.0);
}

TEST(ParameterFile, CellThatThePackDoesNotHaveIsRefused) {
  STRCMP_CONTAINS("a cell from 1 to 24", complaint_of({"battery.cells.25.capacity_scale=0.9"}).c_str());
  STRCMP_CONTAINS("unknown key", complaint_of({"battery.cells.0.capacity_scale=0.9"}).c_str());
}

TEST(ParameterFile, UnknownKeyIsRefusedWithTheNearestNamed) {
  STRCMP_CONTAINS("\"vehicle.mass_kg\"", complaint_of({"vehicle.mas_kg=240"}).c_str());
}

TEST(ParameterFile, UnknownKeyInAFileIsNamedByFileAndLine) {
  STRCMP_CONTAINS("car.toml:3: found the unknown key \"vehicle.mas_kg\"",
                  complaint_of({}, car_with("[vehicle]\nmas_kg = 240.0\n")).c_str());
}

TEST(ParameterFile, WrongTypeIsNamedByFileAndLine) {
  const std::string message = complaint_of({}, car_with("[vehicle]\nmass_kg = \"light\"\n"));
  STRCMP_CONTAINS("car.toml:3, vehicle.mass_kg: found", message.c_str());
  STRCMP_CONTAINS("a number in kg from 20 to 3000", message.c_str());
}

TEST(ParameterFile, WholeNumberKeyRefusesAFraction) {
  STRCMP_CONTAINS("a whole number", complaint_of({"battery.cells_in_series=23.5"}).c_str());
}

TEST(ParameterFile, RangeEndsAreInsideAndWhatIsBeyondIsNot) {
  DOUBLES_EQUAL(20.0, with({"vehicle.mass_kg=20"}).vehicle.mass_kg, 0.0);
  DOUBLES_EQUAL(3000.0, with({"vehicle.mass_kg=3000"}).vehicle.mass_kg, 0.0);
  STRCMP_CONTAINS("expected", complaint_of({"vehicle.mass_kg=19.999"}).c_str());
  STRCMP_CONTAINS("expected", complaint_of({"vehicle.mass_kg=3000.001"}).c_str());
  STRCMP_CONTAINS("expected", complaint_of({"vehicle.mass_kg=nan"}).c_str());
}

TEST(ParameterFile, BrokenTomlIsNamedByFileAndLine) {
  STRCMP_CONTAINS("car.toml:3: found no valid TOML", complaint_of({}, car_with("[vehicle]\nmass_kg = \n")).c_str());
}

TEST(ParameterFile, MissingKeyIsNamedWithUnitAndRange) {
  const std::string message =
      complaint_of({}, scratch.write("bare.toml", "[vehicle]\n[battery]\ncell = \"aesc_e5_2p\"\n"));
  STRCMP_CONTAINS("no vehicle.driver_mass_kg; expected a number in kg", message.c_str());
}

TEST(ParameterFile, OfTwoWaysToGiveAMassTheLaterHoldsAndOneFileGivesOne) {
  DOUBLES_EQUAL(0.0, with({"vehicle.mass_without_pack_kg=190"}).vehicle.mass_kg, 0.0);
  const std::string bare = car_with("[vehicle]\nmass_without_pack_kg = 190\n");
  DOUBLES_EQUAL(200.0, with({"vehicle.mass_kg=200"}, bare).vehicle.mass_kg, 0.0);
  const std::string both = car_with("[vehicle]\nmass_kg = 240\nmass_without_pack_kg = 190\n");
  STRCMP_CONTAINS("two masses", complaint_of({}, both).c_str());
}

TEST(ParameterFile, AKeyOfEarlierVersionsSaysWhatStandsInItsPlace) {
  STRCMP_CONTAINS("tyres.pacejka_d is its grip", complaint_of({"tyres.friction=1.2"}).c_str());
}

TEST(ParameterFile, PackFileIsDrivenInTheStandardCar) {
  const std::string path = scratch.write("pack.toml", "[battery]\ncells_in_series = 20\n");
  const VehicleParameters car = with({}, path);
  CHECK_EQUAL(20, car.battery.cells_in_series);
  DOUBLES_EQUAL(with({}).vehicle.mass_kg, car.vehicle.mass_kg, 0.0);
  STRCMP_EQUAL("pack", car.name.c_str());
}

TEST(ParameterFile, VehiclesThatNameEachOtherAsBaseAreRefused) {
  const std::string a = scratch.write("a.toml", "base = \"b.toml\"\n");
  scratch.write("b.toml", "base = \"a.toml\"\n");
  STRCMP_CONTAINS("circle", complaint_of({}, a).c_str());
}

TEST(ParameterFile, UnknownVehicleListsTheKnownOnes) {
  STRCMP_CONTAINS("vtm16e, vtm17e", complaint_of({}, "vtm18").c_str());
}

TEST(ParameterFile, AVehicleMayBeTheBaseOfTwoLevels) {
  scratch.write("b.toml", "base = \"vtm17e\"\n[vehicle]\nmass_kg = 230.0\n");
  DOUBLES_EQUAL(230.0, with({}, scratch.write("a.toml", "base = \"b.toml\"\n")).vehicle.mass_kg, 0.0);
}

TEST(ParameterFile, SettingWithoutAnEqualsSignIsRefused) {
  STRCMP_CONTAINS("--set vehicle.mass_kg=219", complaint_of({"vehicle.mass_kg"}).c_str());
  STRCMP_CONTAINS("--set vehicle.mass_kg=219", complaint_of({"vehicle.mass_kg="}).c_str());
}

TEST(ParameterFile, CellFileIsFoundBesideTheVehicleFile) {
  scratch.write("own.toml", "base_is_missing = 1\n");
  STRCMP_CONTAINS("own.toml:1: found the unknown key \"cell.base_is_missing\"",
                  complaint_of({}, car_with("[battery]\ncell = \"own.toml\"\n")).c_str());
}
