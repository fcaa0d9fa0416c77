// SPDX-License-Identifier: Apache-2.0
// Bounds of causes that depend on the cell: there is no less than nothing of a hysteresis or a slow relaxation.
#include "discrepancy/causes/list.hpp"

#include <CppUTest/TestHarness.h>

#include "discrepancy/model.hpp"

using namespace voltlap::plant;

TEST_GROUP(Causes) {
  CellParameters cell = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world.car.cell;

  double lowest(const std::string& name) const {
    std::vector<Cause> causes = catalogue({});
    size_for(cell, causes);
    for (const Cause& cause : causes) {
      if (name == cause.name) return cause.parameters[0].low;
    }
    FAIL("no such cause");
    return 0.0;
  }
};

TEST(Causes, ACellThatHasNoneCanHaveNoLessHysteresisOrSlowRelaxation) {
  DOUBLES_EQUAL(0.0, lowest("hysteresis"), 0.0);
  DOUBLES_EQUAL(0.0, lowest("slow_relaxation"), 0.0);
}

TEST(Causes, WhatAModelHasCanBeTakenAway) {
  cell.effects.hysteresis_v = 0.02;
  cell.effects.slow_relaxation_ohm = 3e-4;
  DOUBLES_EQUAL(-0.02, lowest("hysteresis"), 0.0);
  DOUBLES_EQUAL(-3e-4, lowest("slow_relaxation"), 0.0);
}
