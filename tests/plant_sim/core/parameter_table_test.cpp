// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_table.hpp"

#include <set>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ParameterTable) {};

TEST(ParameterTable, EveryKeyStandsOnce) {
  std::set<std::string_view> keys;
  for (const ParameterRow& row : parameter_rows()) CHECK_TRUE_TEXT(keys.insert(row.key).second, row.key.data());
}

TEST(ParameterTable, NoTwoKeysShareAField) {
  VehicleParameters car;
  std::set<const void*> places;
  for (const ParameterRow& row : parameter_rows()) {
    const void* place = std::visit([&](auto access) -> const void* { return &access(car); }, row.access);
    CHECK_TRUE_TEXT(places.insert(place).second, row.key.data());
  }
}

TEST(ParameterTable, EveryRowHasUnitDescriptionAndARangeInOrder) {
  for (const ParameterRow& row : parameter_rows()) {
    CHECK_TRUE_TEXT(!row.unit.empty() && !row.description.empty(), row.key.data());
    CHECK_TRUE_TEXT(row.unit == "-" ? row.low == row.high : row.low < row.high, row.key.data());
  }
}

TEST(ParameterTable, KeyWithoutItsSectionFindsTheFullKey) {
  STRCMP_EQUAL("battery.cells_in_series", nearest_key("cells_in_series").c_str());
}

TEST(ParameterTable, MisspeltKeyFindsTheOneWithFewestEdits) {
  STRCMP_EQUAL("powertrain.final_drive", nearest_key("powertrain.finaldrive").c_str());
  STRCMP_EQUAL("battery.cells.<n>.capacity_scale", nearest_key("battery.cells.3.capacity_skale").c_str());
}

TEST(ParameterTable, NothingIsNearWhenMoreEditsAreNeededThanAllowed) {
  STRCMP_EQUAL("", nearest_of("lincoln", {"michigan_2014", "michigan_2015"}, 3).c_str());
  STRCMP_EQUAL("michigan_2015", nearest_of("michigan2015", {"michigan_2014", "michigan_2015"}, 3).c_str());
}

TEST(ParameterTable, ExpectationNamesTypeUnitAndRange) {
  STRCMP_EQUAL("a number in kg from 20 to 3000", expectation(*find_parameter("vehicle.mass_kg")).c_str());
  STRCMP_EQUAL("a whole number from 1 to 144", expectation(*find_parameter("battery.cells_in_series")).c_str());
  STRCMP_EQUAL("true or false", expectation(*find_parameter("sensors.noise")).c_str());
}

TEST(ParameterTable, ValuesOfACarIncludeItsSingleCells) {
  VehicleParameters car;
  car.battery.cells = {{}, {.capacity_scale = 0.92}};
  for (const auto& [key, value] : parameter_values(car)) {
    if (key == "battery.cells.2.capacity_scale") {
      STRCMP_EQUAL("0.92", value.c_str());
      return;
    }
  }
  FAIL("battery.cells.2.capacity_scale is not listed");
}
