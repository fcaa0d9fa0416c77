// SPDX-License-Identifier: Apache-2.0
#include "io/logs/signal_words.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(SignalWords){
    void means(const char* name, Meaning meaning, Owner owner){const SpokenName spoken = spoken_name(name);
CHECK_TEXT(spoken.meaning == meaning, name);
CHECK_TEXT(spoken.owner == owner, name);
}
}
;

TEST(SignalWords, NamesArePartedAtMarksDigitsAndCapitals) {
  const auto words = words_of("HvBatteryCurrent_2");
  CHECK(words == std::vector<std::string>({"hv", "battery", "current", "2"}));
  CHECK(words_of("LBCurrent") == std::vector<std::string>({"lb", "current"}));
}

TEST(SignalWords, AQuantityIsKnownInTheLanguagesOfLoggers) {
  for (const char* name :
       {"Current", "Strom", "courant", "corriente", "corrente", "电流", "Batteriestrom [A]", "i_a"})
    CHECK_TEXT(spoken_name(name).meaning == Meaning::kCurrent, name);
  for (const char* name : {"Voltage(V)", "Spannung", "tension/V", "voltaje", "电压", "VoltageCell07", "v_pack_v"})
    CHECK_TEXT(spoken_name(name).meaning == Meaning::kVoltage, name);
  for (const char* name : {"Zeit", "temps [s]", "tiempo", "时间", "Test_Time(s)"})
    CHECK_TEXT(spoken_name(name).meaning == Meaning::kTime, name);
  for (const char* name : {"ch1", "col_a", "x", "LB_2"})
    CHECK_TEXT(spoken_name(name).meaning == Meaning::kNothing, name);
}

TEST(SignalWords, TheOwnerIsTold) {
  means("PackCurrent", Meaning::kCurrent, Owner::kPack);
  means("Zwischenkreisspannung", Meaning::kVoltage, Owner::kBus);
  means("cell_3_voltage_v", Meaning::kVoltage, Owner::kCell);
  means("tc4_ambient_c", Meaning::kTemperature, Owner::kAmbient);
}

TEST(SignalWords, WhatIsNoMeasurementOfTheBatteryIsKnown) {
  for (const char* name :
       {"DischargeCurrentLimit", "Strom Soll", "current_filtered", "I_set", "courant consigne", "Imax 2 max"})
    CHECK_FALSE_TEXT(spoken_name(name).is_actual, name);
  for (const char* name : {"INV_DC_Current", "Motor Current", "Phase Current A"})
    CHECK_TRUE_TEXT(spoken_name(name).is_others, name);
}

TEST(SignalWords, TheSpeedOfAMotorIsKnownByItsUnitToo) {
  for (const char* name :
       {"Motor_RPM", "Motor RPM", "Engine RPM", "E-Motor RPM", "MotorRPM", "Motor [rad/s]", "INV_Motor_Speed",
        "Drehzahl (1/min)", "Motordrehzahl [U/min]", "Régime moteur (tr/min)", "Motor speed (rev/min)",
        "giri motore (giri/min)", "Varvtal motor [rpm]", "电机转速(rpm)", "обороты двигателя (об/мин)"})
    CHECK_TEXT(spoken_name(name).meaning == Meaning::kMotorSpeed, name);
  for (const char* name :
       {"Gyro Z [rad/s]", "Pump RPM", "Motor fan (rpm)", "Yaw rate (rad/s)", "Motor temperature", "ERPM"})
    CHECK_FALSE_TEXT(spoken_name(name).meaning == Meaning::kMotorSpeed, name);
  means("Wheel FL [rpm]", Meaning::kNothing, Owner::kWheel);
}

TEST(SignalWords, TheNumberOfAFamilyIsFoundWhereverItStands) {
  const SpokenName spoken = spoken_name("cell_12_voltage_v");
  CHECK_EQUAL(12, *spoken.number);
  STRCMP_EQUAL("cell_<n>_voltage_v", spoken.pattern.c_str());
}
