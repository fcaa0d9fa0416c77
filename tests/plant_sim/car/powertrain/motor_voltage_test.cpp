// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/motor_voltage.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(MotorVoltage) {
  const DataFolder data{VOLTLAP_SOURCE_DIR "/plant_sim/data"};

  std::string complaint(const std::vector<std::string>& settings) {
    return input_error([&] { check_motor_voltage(load_vehicle(data, "vtm16e", settings)); });
  }
};

TEST(MotorVoltage, AMotorThatStatesNoneBearsAnyPack) {
  STRCMP_EQUAL("", complaint({"battery.cells_in_series=144"}).c_str());
  STRCMP_EQUAL("", complaint({"motor.voltage_max_v=10", "powertrain.kind=none"}).c_str());
}

TEST(MotorVoltage, APackThatIsFullAndTooHighIsRefusedWithTheNumbersAndTheCellsThatFit) {
  const std::string message = complaint({"motor.voltage_max_v=90"});
  STRCMP_CONTAINS("--set motor.voltage_max_v: found a full pack of 100.1 V", message.c_str());
  STRCMP_CONTAINS("24 cells in series", message.c_str());
  STRCMP_CONTAINS("expected at most 90 V", message.c_str());
  STRCMP_CONTAINS("Take at most 21 for battery.cells_in_series", message.c_str());
  STRCMP_EQUAL("", complaint({"motor.voltage_max_v=90", "battery.cells_in_series=21"}).c_str());
  CHECK(complaint({"motor.voltage_max_v=90", "battery.cells_in_series=22"}) != "");
}

TEST(MotorVoltage, AnEmptyPackIsLookedAtAsAFullOneAndTheMotorsFileIsNamed) {
  const std::string message =
      complaint({"motor.model=emrax_228_lv", "battery.cells_in_series=36", "battery.initial_soc=0.1"});
  STRCMP_CONTAINS("emrax_228_lv.toml:", message.c_str());
  STRCMP_CONTAINS("motor.voltage_max_v", message.c_str());
}
