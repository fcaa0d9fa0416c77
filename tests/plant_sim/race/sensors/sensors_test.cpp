// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/sensors.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

struct Statistics {
  double mean, deviation;
};

template <class Read>
Statistics statistics(const Read& read) {
  constexpr int kCount = 20000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = read();
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kCount;
  return {mean, std::sqrt(squares / kCount - mean * mean)};
}

}  // namespace

TEST_GROUP(Sensors) {
  SensorSection section = vtm16e().sensors;
};

TEST(Sensors, ReadTheTruthByDefault) {
  Sensors sensors(section, 1);
  DOUBLES_EQUAL(3.141592653589, sensors.cell_voltage(3.141592653589), 0.0);
  DOUBLES_EQUAL(-123.456789, sensors.current(-123.456789), 0.0);
  DOUBLES_EQUAL(27.1828, sensors.temperature(27.1828), 0.0);
}

TEST(Sensors, QuantisationRoundsToTheStepsOfTheInstruments) {
  section.quantisation = true;
  Sensors sensors(section, 1);
  DOUBLES_EQUAL(4.1700, sensors.cell_voltage(4.1694), 1e-12);
  DOUBLES_EQUAL(31.0, sensors.temperature(30.6), 1e-12);
  DOUBLES_EQUAL(74.9, sensors.current(74.93), 1e-9);
  DOUBLES_EQUAL(-74.9, sensors.current(-74.93), 1e-9);
}

TEST(Sensors, TheCoarseChannelServesOutsideTheFineOnesRange) {
  section.quantisation = true;
  Sensors sensors(section, 1);
  DOUBLES_EQUAL(75.0, sensors.current(74.97), 1e-9);
  DOUBLES_EQUAL(76.0, sensors.current(75.6), 1e-9);
  DOUBLES_EQUAL(-200.0, sensors.current(-200.4), 1e-9);
}

TEST(Sensors, NoiseHasTheMeanOfTheTruthAndItsDeviation) {
  section.noise = true;
  Sensors sensors(section, 3);
  const Statistics cell = statistics([&] { return sensors.cell_voltage(3.7); });
  DOUBLES_EQUAL(3.7, cell.mean, 5e-5);
  DOUBLES_EQUAL(0.0015, cell.deviation, 0.03 * 0.0015);
  const Statistics fine = statistics([&] { return sensors.current(20.0); });
  DOUBLES_EQUAL(20.0, fine.mean, 0.003);
  DOUBLES_EQUAL(0.1, fine.deviation, 0.003);
  DOUBLES_EQUAL(1.0, statistics([&] { return sensors.current(-150.0); }).deviation, 0.03);
  DOUBLES_EQUAL(0.1, statistics([&] { return sensors.temperature(30.0); }).deviation, 0.003);
}

TEST(Sensors, OneSeedGivesOneSeriesAndAnotherSeedAnother) {
  section.noise = true;
  Sensors a(section, 5), b(section, 5), c(section, 6);
  bool differs = false;
  for (int i = 0; i < 100; ++i) {
    const double reading = a.cell_voltage(3.7);
    DOUBLES_EQUAL(reading, b.cell_voltage(3.7), 0.0);
    differs = differs || reading != c.cell_voltage(3.7);
  }
  CHECK(differs);
}
