// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/table_sensitivity.hpp"

#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(TableSensitivity) {
  CellParameters cell = StraightCell::cell();
  TableSensitivity of(TableParameter parameter) {
    for (const TableSensitivity& one : table_sensitivities(cell)) {
      if (one.parameter == parameter) return one;
    }
    FAIL("no such table");
    return {};
  }
};

TEST(TableSensitivity, StraightTableHasItsSlopeOverItsMean) {
  // R0 = 10 mOhm + 0.1 mOhm/A I: over 0 to 40 A the mean is 12 mOhm, so 100 * 0.1 / 12 %/A.
  cell.r0_ohm = {};
  for (int line = 0; line < 6; ++line) {
    for (const double i : cell.current_breakpoints_a) cell.r0_ohm.table.push_back(0.010 + 1e-4 * i);
  }
  DOUBLES_EQUAL(100.0 / 120.0, *of(TableParameter::kR0).pct_per_ampere, 1e-9);
  DOUBLES_EQUAL(0.0, *of(TableParameter::kR0).pct_per_kelvin, 1e-12);
}

TEST(TableSensitivity, EachStepCountsOnceHoweverLong) {
  // Eq. 7.1 takes the mean of the differences, not the slope from end to end: steps of 1 A and 9 A.
  cell.current_breakpoints_a = {0.0, 1.0, 10.0};
  cell.branches[0].tau_s = {};
  std::vector<double>& taus = cell.branches[0].tau_s.table;
  for (int line = 0; line < 6; ++line) taus.insert(taus.end(), {10.0, 11.0, 11.0});
  DOUBLES_EQUAL(100.0 * 0.5 * (1.0 + 0.0) / (32.0 / 3.0), *of(TableParameter::kTau1).pct_per_ampere, 1e-9);
}

TEST(TableSensitivity, CoefficientsOfTheFileComeBack) {
  // Breakpoints lie evenly about the reference: the mean is the reference's value.
  cell.branches[0].r_ohm.per_kelvin = -0.019;
  DOUBLES_EQUAL(-1.9, *of(TableParameter::kR1).pct_per_kelvin, 1e-9);
}

TEST(TableSensitivity, SocPointsAreAveragedEachByItsOwnMean) {
  cell.branches[1].r_ohm = {};
  std::vector<double>& ohms = cell.branches[1].r_ohm.table;
  for (const double scale : {1.0, 100.0}) {
    for (const double t : {1.0, 1.1, 1.2}) ohms.insert(ohms.end(), 5, 1e-4 * scale * t);
  }
  DOUBLES_EQUAL(100.0 * 0.01 / 1.1, *of(TableParameter::kR2).pct_per_kelvin, 1e-9);
}

TEST(TableSensitivity, AnAxisOfOnePointTellsNothing) {
  cell.current_breakpoints_a = {20.0};
  CHECK(!of(TableParameter::kR0).pct_per_ampere.has_value());
  CHECK(of(TableParameter::kR0).pct_per_kelvin.has_value());
}

TEST(TableSensitivity, EmNeedsItsOwnTable) {
  CHECK(!of(TableParameter::kEm).pct_per_kelvin.has_value());
  for (int line = 0; line < 2; ++line) {
    for (const double t : {3.9, 4.0, 4.1}) cell.ocv_table_v.insert(cell.ocv_table_v.end(), 5, t);
  }
  DOUBLES_EQUAL(100.0 * 0.01 / 4.0, *of(TableParameter::kEm).pct_per_kelvin, 1e-9);
}
