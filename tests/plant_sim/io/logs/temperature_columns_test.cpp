// SPDX-License-Identifier: Apache-2.0
// No temperature of a cell's test is left out in silence, whatever its column is called.
#include "io/logs/temperature_columns.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <random>
#include <string>

#include "io/logs/cell_log.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

constexpr double kCell_c = 12.5;

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoull(given, nullptr, 10)) : std::random_device{}();
}

std::string test_with(const std::string& names, const std::string& values) {
  std::string out = "time_s,current_a,voltage_v," + names + "\n";
  for (int k = 0; k < 60; ++k) out += fmt::format("{},{},{},{}\n", k, k % 20 < 10 ? 0.0 : 3.0, 3.9, values);
  return out;
}

bool notes_say(const CellLog& log, const std::string& column) {
  for (const std::string& note : log.repairs) {
    if (note.find("\"" + column + "\"") != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_GROUP(TemperatureColumns) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  CellLog log_of(const std::string& names, const std::string& values) {
    return read_cell_log(scratch.write("a.csv", test_with(names, values)), nullptr, data);
  }
};

TEST(TemperatureColumns, ADrawnNameIsTheCellsOrTheAirs) {
  constexpr std::array kCell{"temperature", "Temp", "Cell Temp", "Zelltemperatur", "Aux_Temperature_1", "TC1", "T1",
                             "Thermocouple A", "Auxiliary channel TU1 T", "Température", "电池温度", "temp3"};
  constexpr std::array kAir{"Chamber temperature", "Kammertemperatur", "Température enceinte", "Ambient Temp",
                            "Umgebungstemperatur", "Aux_Temperature(Chamber)", "Oven temp", "Klimakammer Temp"};
  constexpr std::array kUnits{"", "(C)", " [degC]", "/°C", "(℃)", " (K)", "[°F]"};
  const unsigned seed = drawn_seed();
  fmt::print("VOLTLAP_TEST_SEED={}\n", seed);
  std::mt19937 random(seed);
  for (int k = 0; k < 200; ++k) {
    const bool air = random() % 2 == 0;
    const std::size_t unit = random() % kUnits.size();
    const char* word = air ? kAir[random() % kAir.size()] : kCell[random() % kCell.size()];
    const std::string name = std::string(word) + kUnits[unit];
    const double shown = unit == 5 ? kCell_c + 273.15 : unit == 6 ? kCell_c * 1.8 + 32.0 : kCell_c;
    const CellLog log = log_of(name, fmt::format("{}", shown));
    const std::vector<double>& values = air ? log.ambient_c : log.temperature_c;
    CHECK_TEXT(values.size() == log.rows(), name.c_str());
    DOUBLES_EQUAL_TEXT(kCell_c, values[30], 1e-6, name.c_str());
    CHECK_TEXT(notes_say(log, name), name.c_str());
  }
}

TEST(TemperatureColumns, OfWhatIsNoCellOrTwiceThereTheNotesSaySo) {
  const CellLog motor = log_of("Motor Temp (C)", "61");
  CHECK(motor.temperature_c.empty());
  CHECK(notes_say(motor, "Motor Temp (C)"));
  const CellLog cold = log_of("Temp [K]", "12.5");  // of no cell
  CHECK(cold.temperature_c.empty());
  CHECK(notes_say(cold, "Temp [K]"));
  const CellLog two = log_of("TC1,TC2,Chamber(C)", "20,25,18");
  DOUBLES_EQUAL(20.0, two.temperature_c[0], 0.0);
  DOUBLES_EQUAL(18.0, two.ambient_c[0], 0.0);
  CHECK(notes_say(two, "TC2"));
}

TEST(TemperatureColumns, TimesPressuresAndOffsetsAreNone) {
  for (const char* name : {"Temps écoulé", "tempo", "Chamber pressure (bar)", "offset", "Pair", "Template", "Step"}) {
    const CellLog log = log_of(name, "12.5");
    CHECK_TEXT(log.temperature_c.empty() && log.ambient_c.empty(), name);
    CHECK_FALSE_TEXT(notes_say(log, name), name);
  }
}
