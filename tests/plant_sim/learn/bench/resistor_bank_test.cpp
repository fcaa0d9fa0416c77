// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/resistor_bank.hpp"

#include "bench_fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(ResistorBank) {
  LoadSection load = shipped_plan("pulse_15").load;
};

TEST(ResistorBank, NominalCurrentsOfTheStudyChooseItsResistors) {
  struct Row {
    double current_a;
    int resistors;
    double nominal_a;
  };
  for (const Row row : {Row{35, 0, 35.35}, {100, 2, 101.33}, {200, 4, 202.67}, {300, 6, 304.0}, {400, 8, 405.33}}) {
    const BankChoice choice = choose_bank(load, 4, row.current_a);
    LONGS_EQUAL(row.resistors, choice.resistors);
    DOUBLES_EQUAL(row.nominal_a, choice.nominal_a, 0.01);
  }
}

TEST(ResistorBank, HighBankGoesInStepsOfFiftyAmperesTo507) {
  DOUBLES_EQUAL(50.67, high_bank(load, 4, 1).nominal_a, 0.01);
  DOUBLES_EQUAL(506.67, high_bank(load, 4, 10).nominal_a, 0.01);
  DOUBLES_EQUAL(0.03, high_bank(load, 4, 10).resistance_ohm, 1e-12);
}

TEST(ResistorBank, WithoutALowBankTheFirstOfTheHighBankServes) {
  load.low_bank_ohm = 0.0;
  LONGS_EQUAL(1, choose_bank(load, 4, 35.0).resistors);
}

TEST(ResistorBank, CurrentObeysOhmsLawAtTheTerminals) {
  const PackThevenin source{16.4, 0.0061};
  const double current = resistor_current(source, 0.05);
  DOUBLES_EQUAL(current * 0.05, source.voltage_v - source.resistance_ohm * current, 1e-12);
}
