// SPDX-License-Identifier: Apache-2.0
#include "bms/state.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap::bms;

TEST_GROUP(BmsState){};

TEST(BmsState, AnyContactorThatIsToCloseIsACommand) {
  for (unsigned which = 0; which < 8; ++which) {
    CHECK_EQUAL(which != 0, commanded({(which & 1U) != 0, (which & 2U) != 0, (which & 4U) != 0}));
  }
}
