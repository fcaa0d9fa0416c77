// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/pack_comparison.hpp"

#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(PackComparison) {
  CellParameters cell = StraightCell::cell();
  CellLog log = StraightCell::record(StraightCell::half());
  PackComparison with(const CellSpread& spread) {
    return compare_pack(cell, place_recording(CellModel(cell), log, {}), 24, spread);
  }
};

TEST(PackComparison, OneCellStandsForEqualCells) {
  const PackDifference d = with({0.0, 0.0, 0.0, 1}).equal;
  DOUBLES_EQUAL(0.0, d.voltage_max_v, 1e-9);
  DOUBLES_EQUAL(0.0, d.soc_max, 1e-12);
  CHECK(d.snr > 1e9);
  DOUBLES_EQUAL(24.0 * (3.5 - 0.2), d.voltage_low_v, 0.02);
}

TEST(PackComparison, CellsWithoutSpreadDoNotDiffer) {
  const PackComparison found = with({0.0, 0.0, 0.0, 1});
  DOUBLES_EQUAL(found.equal.voltage_mean_v, found.differing.voltage_mean_v, 1e-12);
  DOUBLES_EQUAL(0.0, found.differing.weakest_cell_v, 1e-9);
}

TEST(PackComparison, SpreadOfInitialSocShiftsTheMeanAndTheWeakest) {
  // On a straight OCV of 1 V over SOC the pack's voltage is off by the sum of the offsets, at every moment.
  const PackDifference d = with({0.0, 0.0, 0.01, 3}).differing;
  DOUBLES_EQUAL(d.soc_max * 24.0, std::abs(d.voltage_mean_v), 1e-6);
  DOUBLES_EQUAL(std::abs(d.voltage_mean_v), d.voltage_max_v, 1e-6);
  CHECK(d.weakest_cell_v > 0.01 && d.weakest_cell_v < 0.04);
}

TEST(PackComparison, SameSeedDrawsTheSameCells) {
  DOUBLES_EQUAL(with({}).differing.voltage_mean_v, with({}).differing.voltage_mean_v, 0.0);
}
