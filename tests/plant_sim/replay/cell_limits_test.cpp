// SPDX-License-Identifier: Apache-2.0
#include "replay/cell_limits.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap::plant;

TEST_GROUP(CellLimits) {
  std::vector<LimitViolation> found;
  CellLimits limits{2.5, 4.2, found};
};

TEST(CellLimits, the_limits_themselves_are_allowed) {
  limits.sample(1.0, 0, 2.5);
  limits.sample(2.0, 0, 4.2);
  limits.finish();
  CHECK(found.empty());
}

TEST(CellLimits, a_stretch_has_its_begin_its_end_and_its_worst) {
  const double volts[] = {2.6, 2.4, 2.1, 2.3, 2.6};
  for (int k = 0; k < 5; ++k) limits.sample(k, 6, volts[k]);
  limits.finish();
  LONGS_EQUAL(1, found.size());
  LONGS_EQUAL(7, found[0].cell);
  DOUBLES_EQUAL(1.0, found[0].time_s, 0.0);
  DOUBLES_EQUAL(3.0, found[0].until_s, 0.0);
  DOUBLES_EQUAL(2.1, found[0].voltage_v, 0.0);
  DOUBLES_EQUAL(2.5, found[0].limit_v, 0.0);
}

TEST(CellLimits, below_and_above_are_two_stretches_and_cells_do_not_mix) {
  limits.sample(1.0, 1, 4.3);
  limits.sample(2.0, 0, 2.4);
  limits.sample(3.0, 0, 4.5);
  limits.finish();
  LONGS_EQUAL(3, found.size());
  LONGS_EQUAL(2, found[0].cell);
  DOUBLES_EQUAL(2.4, found[1].voltage_v, 0.0);
  DOUBLES_EQUAL(4.2, found[2].limit_v, 0.0);
}

TEST(CellLimits, a_masked_reading_ends_no_stretch) {
  limits.sample(1.0, 0, 2.4);
  limits.sample(2.0, 0, kUnknown);
  limits.sample(3.0, 0, 2.3);
  limits.finish();
  LONGS_EQUAL(1, found.size());
  DOUBLES_EQUAL(3.0, found[0].until_s, 0.0);
}
