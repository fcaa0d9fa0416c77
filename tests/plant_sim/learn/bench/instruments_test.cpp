// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/instruments.hpp"

#include <algorithm>
#include <cmath>

#include "bench_fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Instruments) {
  InstrumentSection section = shipped_plan("pulse_15").instruments;

  Instruments without_noise() {
    section.sensors.noise = false;
    section.systematic = false;
    return Instruments(section, draw_errors(section, 4, 1), 1);
  }
};

TEST(Instruments, CellVoltageComesInStepsOf1500Microvolts) {
  Instruments instruments = without_noise();
  DOUBLES_EQUAL(3.7005, instruments.cell_voltage(0, 3.7010), 1e-9);
  DOUBLES_EQUAL(3.7020, instruments.cell_voltage(0, 3.7014), 1e-9);
}

TEST(Instruments, CurrentHasTenthsBelow75AmperesAndWholeOnesAbove) {
  Instruments instruments = without_noise();
  DOUBLES_EQUAL(34.9, instruments.current(34.93), 1e-9);
  DOUBLES_EQUAL(75.0, instruments.current(74.96), 1e-9);
  DOUBLES_EQUAL(305.0, instruments.current(304.6), 1e-9);
  DOUBLES_EQUAL(-305.0, instruments.current(-304.6), 1e-9);
}

TEST(Instruments, ThermistorsHaveWholeDegrees) {
  Instruments instruments = without_noise();
  DOUBLES_EQUAL(31.0, instruments.cell_temperature(2, 30.6), 1e-9);
  DOUBLES_EQUAL(22.0, instruments.air_temperature(22.4), 1e-9);
}

TEST(Instruments, NoiseAndStepTogetherSpreadAsTheyShould) {
  section.systematic = false;
  Instruments instruments(section, draw_errors(section, 1, 1), 7);
  constexpr int kReadings = 20000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kReadings; ++i) {
    const double deviation = instruments.cell_voltage(0, 3.7003) - 3.7003;
    sum += deviation;
    squares += deviation * deviation;
  }
  const double expected = std::sqrt(0.0015 * 0.0015 + 0.0015 * 0.0015 / 12.0);  // noise and the step's own
  DOUBLES_EQUAL(0.0, sum / kReadings, 5.0 * expected / std::sqrt(kReadings));
  DOUBLES_EQUAL(expected, std::sqrt(squares / kReadings), 0.03 * expected);
}

TEST(Instruments, SystematicErrorsStayWithinTheDataSheetsAndFillThem) {
  double worst_cell = 0.0, worst_40a = 0.0, worst_500a = 0.0, hottest = 0.0, coldest = 0.0;
  section.sensors.noise = section.sensors.quantisation = false;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Instruments instruments(section, draw_errors(section, 4, seed), 1);
    worst_cell = std::max(worst_cell, std::abs(instruments.cell_voltage(1, 5.0) - 5.0));
    worst_40a = std::max(worst_40a, std::abs(instruments.current(40.0) - 40.0));
    worst_500a = std::max(worst_500a, std::abs(instruments.current(500.0) - 500.0));
    hottest = std::max(hottest, instruments.cell_temperature(3, 0.0));
    coldest = std::min(coldest, instruments.cell_temperature(3, 0.0));
  }
  CHECK(worst_cell <= 0.0125 + 1e-12 && worst_cell > 0.010);
  CHECK(worst_40a <= 0.8 + 1e-9 && worst_40a > 0.65);
  CHECK(worst_500a <= 13.0 + 1e-9 && worst_500a > 10.5);
  CHECK(hottest <= 1.0 && hottest > 0.9);
  CHECK(coldest >= 0.0);
}

TEST(Instruments, WithoutSystematicErrorsNothingIsWrongAllDay) {
  section.systematic = false;
  const InstrumentErrors errors = draw_errors(section, 4, 3);
  DOUBLES_EQUAL(0.0, errors.current_high_gain, 0.0);
  DOUBLES_EQUAL(0.0, errors.current_low_offset_a, 0.0);
  for (std::size_t cell = 0; cell < 4; ++cell) {
    DOUBLES_EQUAL(0.0, errors.cell_offset_v[cell], 0.0);
    DOUBLES_EQUAL(0.0, errors.temperature_offset_k[cell], 0.0);
  }
}

TEST(Instruments, EachCellInputAndEachThermistorIsWrongInItsOwnWay) {
  const InstrumentErrors errors = draw_errors(section, 2, 9);
  CHECK(errors.cell_offset_v[0] != errors.cell_offset_v[1]);
  CHECK(errors.temperature_offset_k[0] != errors.temperature_offset_k[1]);
}
