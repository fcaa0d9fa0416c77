// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/usual.hpp"

#include <CppUTest/TestHarness.h>

namespace voltlap::explain {

TEST_GROUP(Usual){};

TEST(Usual, CriticalValuesOfStudentsT) {
  // Abramowitz and Stegun, Table 26.10.
  DOUBLES_EQUAL(5.041, critical_t(1e-3, 8.0), 2e-3);
  DOUBLES_EQUAL(4.587, critical_t(1e-3, 10.0), 2e-3);
  DOUBLES_EQUAL(3.850, critical_t(1e-3, 20.0), 1e-2);
  CHECK(critical_t(1e-4, 8.0) > critical_t(1e-3, 8.0));
}

}  // namespace voltlap::explain
