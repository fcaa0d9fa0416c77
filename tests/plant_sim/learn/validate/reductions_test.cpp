// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/reductions.hpp"

#include "learn/validate/validation_text.hpp"
#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Reductions) {
  CellParameters cell = StraightCell::cell();
  CellLog log;

  /// R0 that falls with current: 12 mOhm at 0 A, 8 mOhm at 40 A, in cell and recording.
  void setup() override {
    cell.r0_ohm = {};
    for (int line = 0; line < 6; ++line) {
      for (const double i : cell.current_breakpoints_a) cell.r0_ohm.table.push_back(0.012 - 1e-4 * i);
    }
    std::vector<double> currents;
    for (int k = 0; k < 900; ++k) currents.push_back((k / 30) % 2 == 0 ? 40.0 : 10.0);
    log = StraightCell::record(currents, [](double i) { return 0.012 - 1e-4 * i; });
  }
  std::vector<Reduction> all() {
    std::vector<PlacedRecording> recordings;
    recordings.push_back(place_recording(CellModel(cell), log, {}));
    return reductions(cell, recordings);
  }
};

TEST(Reductions, MeanOverTheAxisStandsForEachValue) {
  const std::vector<double> table =
      table_of(without_dependence(cell, TableParameter::kR0, TableAxis::kCurrent), TableParameter::kR0);
  for (const double value : table) DOUBLES_EQUAL(0.010, value, 1e-12);
}

TEST(Reductions, OtherAxisIsKept) {
  cell.r0_ohm.per_kelvin = 0.0;
  const CellParameters same = without_dependence(cell, TableParameter::kR0, TableAxis::kTemperature);
  CHECK(table_of(same, TableParameter::kR0) == table_of(cell, TableParameter::kR0));
}

TEST(Reductions, CostIsWhatTheDroppedDependenceWasWorth) {
  // 8 instead of 10 mOhm at 40 A: 80 mV; 11 instead of 10 at 10 A: 10 mV; half of the time each.
  const std::vector<Reduction> found = all();
  LONGS_EQUAL(2, found.size());
  STRCMP_EQUAL("whole model", reduction_name(found[0]).c_str());
  STRCMP_EQUAL("r0 without current", reduction_name(found[1]).c_str());
  DOUBLES_EQUAL(0.0, found[0].rms_v, 1e-4);
  DOUBLES_EQUAL(std::sqrt(0.5 * (0.080 * 0.080 + 0.010 * 0.010)), found[1].rms_v, 1e-3);
}

TEST(Reductions, EmAndR0AreReducedTogetherAsTheStudyDid) {
  for (const double soc : cell.soc_breakpoints) {
    for (int t = 0; t < 3; ++t) {
      for (const double i : cell.current_breakpoints_a) cell.ocv_table_v.push_back(3.0 + soc + 1e-3 * (i - 20.0));
    }
  }
  bool found = false;
  for (const Reduction& one : all()) found = found || reduction_name(one) == "em, r0 without current";
  CHECK(found);
}
