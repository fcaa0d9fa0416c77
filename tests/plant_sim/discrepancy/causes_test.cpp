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

TEST(Causes, APriorIsLeftAtItsEndsButNotAtZero) {
  const CauseParameter both{"change", "1", -0.5, 0.5, 0.1}, more{"delay_s", "s", 0.0, 1.0, 0.1},
      less{"capacity_change", "1", -1.0, 0.0, 0.1};
  LONGS_EQUAL(0, sign_of(both));
  LONGS_EQUAL(1, sign_of(more));
  LONGS_EQUAL(-1, sign_of(less));
  CHECK(is_inside_prior(both, 0.0) && is_inside_prior(both, 0.47) && is_inside_prior(both, -0.47));
  CHECK_FALSE(is_inside_prior(both, 0.49));
  CHECK_FALSE(is_inside_prior(both, -0.49));
  CHECK(is_inside_prior(more, 1e-6) && is_inside_prior(less, -1e-6));
  CHECK_FALSE(is_inside_prior(more, 0.0));
  CHECK_FALSE(is_inside_prior(more, 0.99));
  CHECK_FALSE(is_inside_prior(less, 0.0));
  CHECK_FALSE(is_inside_prior(less, -0.99));
}
