// SPDX-License-Identifier: Apache-2.0
#include "io/table/unit_name.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(UnitName) {
  static void has(const char* header, const char* name, const char* unit) {
    const ColumnName found = column_name(header);
    STRCMP_EQUAL_TEXT(name, found.name.c_str(), header);
    const auto read = unit_named(found.unit);
    STRCMP_EQUAL_TEXT(unit, read ? std::string(read->name).c_str() : "", header);
  }
};

TEST(UnitName, StandsInANameInEveryFormThatMakersUse) {
  has("Test_Time(s)", "test time", "s");
  has("I [mA]", "i", "mA");
  has("<I>/mA", "i", "mA");
  has("control/V/mA", "control v", "mA");
  has("(Q-Qo)/mA.h", "q qo", "mAh");
  has("Temp (\xC2\xB0" "C)", "temp", "degC");
  has("I_mA", "i", "mA");
  has("Current, A", "current", "A");
  has("Zeit in ms", "zeit", "ms");
  has("\xE7\x94\xB5\xE6\xB5\x81\xEF\xBC\x88mA\xEF\xBC\x89", "\xE7\x94\xB5\xE6\xB5\x81", "mA");
  has("Temperature (C)_1", "temperature 1", "degC");
  has("Lateral acceleration [g]", "lateral acceleration", "g");
  has("lateral_mps2", "lateral mps2", "");
  has("Voltage", "voltage", "");
  has("relative time(h:min:s.ms)", "relative time", "");
}

TEST(UnitName, ScalesAreThoseOfTheUnit) {
  DOUBLES_EQUAL(25.0, 77.0 * unit_named("degF")->scale + unit_named("degF")->offset, 1e-9);
  DOUBLES_EQUAL(25.0, 298.15 + unit_named("[K]")->offset, 1e-9);
  DOUBLES_EQUAL(90.0, 1.5 * unit_named("min")->scale, 1e-12);
  CHECK(!unit_named("furlong") && is_unit_text("Wh") && !is_unit_text("Spannung"));
}
